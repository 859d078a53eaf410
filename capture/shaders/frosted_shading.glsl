// The frosted side of a pane: a rough interface that covers its pixel and lets light through, in all
// directions. After surface.glsl.
flat in vec4 v_color;  // transmission; its alpha is the collimation
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;
uniform vec4 u_parameters[8];  // 0: light that falls on it from both sides

vec4 shade() {
    vec3 to_eye = normalize(v_to_eye);
    vec3 normal = normalize(v_normal);
    surface_normal = dot(normal, to_eye) < 0.0 ? -normal : normal;
    surface_collimation = v_color.a;
    // Light that does not pass comes back, as white as the glass lets it.
    vec3 radiance = u_parameters[0].rgb * (1.0 - v_color.rgb) * v_color.rgb;
    return covering(radiance, 1.0, v_color.rgb);
}
