// Soft round puff: a noise texture under a radial falloff; nothing outside the circle.
flat in vec4 v_look;
in vec2 v_corner;
in vec2 v_texture;
layout(binding = 0) uniform sampler2D u_texture;
uniform vec4 u_parameters[8];  // 0: sunlight, 1: skylight

vec4 shade() {
    float inside = 1.0 - dot(v_corner, v_corner);
    if (inside <= 0.0) discard;
    float noise = textureLod(u_texture, v_texture, 0.0).r;
    float alpha = v_look.y * inside * (0.4 + 1.2 * noise);
    return vec4(u_parameters[0].rgb * v_look.x + u_parameters[1].rgb, alpha);
}
