// A puff of smoke or fire: the texture is its density; follows daylight.glsl.
flat in vec4 v_color;
in vec2 v_texture;
in vec3 v_light;
in float v_clear;
layout(binding = 0) uniform sampler2D u_texture;

vec4 shade() {
    float alpha = texture(u_texture, v_texture).r * v_color.a;
    if (alpha < 1.0 / 512.0) discard;
    return vec4(mix(u_parameters[1].rgb, v_color.rgb * v_light, v_clear), alpha);
}
