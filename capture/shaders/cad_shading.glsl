// A part in a CAD program: one colour, lit from the eye and from above, a little denser at its outline.
flat in vec4 v_color;  // linear; alpha is the coverage seen face on
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;
uniform vec4 u_parameters[8];  // 0: direction towards the light

vec4 shade() {
    vec3 to_eye = normalize(v_to_eye);
    vec3 normal = normalize(v_normal);
    float facing = dot(normal, to_eye);
    normal = facing < 0.0 ? -normal : normal;
    facing = abs(facing);
    float light = 0.35 + 0.35 * facing + 0.4 * max(dot(normal, u_parameters[0].xyz), 0.0);
    float gloss = pow(max(dot(normal, normalize(u_parameters[0].xyz + to_eye)), 0.0), 40.0);
    float edge = (1.0 - facing) * (1.0 - facing);
    surface_normal = normal;
    return vec4(v_color.rgb * light + vec3(0.25 * gloss), min(v_color.a * (1.0 + 1.2 * edge), 1.0));
}
