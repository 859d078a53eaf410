// A thin coloured film, lit from both sides; denser and shinier at grazing angles.
flat in vec4 v_color;
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;
uniform vec4 u_parameters[8];  // 0: direction towards the light

vec4 shade() {
    vec3 to_eye = normalize(v_to_eye);
    vec3 normal = normalize(v_normal);
    float facing = dot(normal, to_eye);
    normal = facing < 0.0 ? -normal : normal;
    float diffuse = 0.35 + 0.65 * max(dot(normal, u_parameters[0].xyz), 0.0);
    vec3 halfway = normalize(u_parameters[0].xyz + to_eye);
    float gloss = pow(max(dot(normal, halfway), 0.0), 48.0);
    float edge = 1.0 - min(abs(facing), 1.0);
    float rim = edge * edge * edge;
    float alpha = min(v_color.a + 0.6 * rim, 1.0);
    vec3 color = v_color.rgb * diffuse + vec3(0.6 * gloss + 0.12 * rim);
    return vec4(color, alpha);
}
