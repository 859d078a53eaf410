// A bank of fog, after street_light: thins out upwards and towards its rim, glows where lamps shine into it.
flat in float v_alpha;
in vec3 v_world;
in vec2 v_corner;
in vec2 v_texture;
layout(binding = 0) uniform sampler2D u_texture;

vec4 shade() {
    float inside = 1.0 - dot(v_corner, v_corner);
    if (inside <= 0.0 || v_world.y <= 0.0) discard;
    float noise = textureLod(u_texture, v_texture, 0.0).r;
    // Nothing cuts hard into the ground.
    float height = smoothstep(0.0, 0.7, v_world.y) * exp2(-0.17 * v_world.y);
    float alpha = v_alpha * inside * height * (0.25 + 1.5 * noise);
    if (alpha < 1.0 / 1024.0) discard;
    vec3 light = vec3(0.05, 0.062, 0.088);
    for (int i = 0; i < 8; ++i) {
        vec3 to_lamp;
        light += 0.75 * lamp_light(i, v_world, to_lamp);
    }
    surface_collimation = 0.2;
    return vec4(light, alpha);
}
