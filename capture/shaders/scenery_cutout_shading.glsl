// Leaves, wire: a texture of colour and coverage, whose edges its mip levels have smoothed beforehand; follows
// daylight.glsl.
flat in vec4 v_color;
in vec2 v_texture;
in vec3 v_light;
in float v_clear;
layout(binding = 0) uniform sampler2D u_texture;

vec4 shade() {
    vec4 texel = texture(u_texture, v_texture);
    float alpha = texel.a * v_color.a;
    if (alpha < 1.0 / 255.0) discard;
    return vec4(mix(u_parameters[1].rgb, texel.rgb * v_color.rgb * v_light, v_clear), alpha);
}
