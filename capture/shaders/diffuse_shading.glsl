// Diffuse surface of constant alpha, lit alike on both sides.
flat in vec4 v_color;
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;
uniform vec4 u_parameters[8];  // 0: direction towards the light

vec4 shade() {
    vec3 normal = normalize(v_normal);
    if (dot(normal, v_to_eye) < 0.0) normal = -normal;
    float light = 0.05 + 0.04 * normal.y + 0.91 * max(dot(normal, u_parameters[0].xyz), 0.0);
    return vec4(v_color.rgb * light, v_color.a);
}
