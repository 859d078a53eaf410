// Diffuse surface under sun and sky.
in vec3 v_color;
in vec4 v_normal;
uniform vec4 u_parameters[8];  // 0: direction towards the light

vec4 shade() {
    vec3 normal = normalize(v_normal.xyz);
    float sun = 0.75 * v_normal.w * max(dot(normal, u_parameters[0].xyz), 0.0);
    float sky = 0.22 + 0.1 * normal.y;
    return vec4(v_color * (sun * vec3(1.05, 1.0, 0.9) + sky * vec3(0.9, 1.0, 1.15)), 1.0);
}
