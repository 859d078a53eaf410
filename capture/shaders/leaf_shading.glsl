// A pointed leaf with a vein, after street_light: whole inside, covering partly along its outline.
flat in vec3 v_color;
flat in vec3 v_normal;
in vec3 v_world;
in vec3 v_to_eye;
in vec2 v_corner;

vec4 shade() {
    float tip = 0.5 + 0.5 * v_corner.y;
    float half_width = 2.6 * sqrt(tip) * (1.0 - tip) + 1e-4;
    float edge = half_width - abs(v_corner.x);
    // The outline is as wide as a pixel, at least a twelfth of the leaf.
    float coverage = clamp(edge / max(fwidth(edge), 0.12), 0.0, 1.0);
    if (coverage <= 0.0) discard;
    vec3 to_eye = normalize(v_to_eye);
    vec3 normal = dot(v_normal, to_eye) < 0.0 ? -v_normal : v_normal;
    vec3 light = vec3(0.03, 0.04, 0.065);
    for (int i = 0; i < 8; ++i) {
        vec3 to_lamp;
        vec3 arrives = lamp_light(i, v_world, to_lamp);
        float facing = dot(normal, to_lamp);
        // Leaves let half of the light through.
        light += arrives * max(facing, -0.5 * facing);
    }
    float vein = 1.0 + 0.35 * smoothstep(0.1, 0.0, abs(v_corner.x));
    surface_normal = normal;
    return vec4(v_color * vein * light, 0.97 * coverage);
}
