// A picture with transparency, lit from both sides.
flat in vec3 v_tint;
in vec2 v_texture;
in float v_light;
layout(binding = 0) uniform sampler2D u_texture;

vec4 shade() {
    vec4 picture = texture(u_texture, v_texture);
    if (picture.a < 0.004) discard;
    return vec4(picture.rgb * v_tint * (0.3 + 0.8 * v_light), picture.a);
}
