// Translucent painted surface, a pane or a thin shell: shinier and denser at grazing angles; follows
// daylight.glsl.
in vec4 v_color;
in vec4 v_normal;
in vec3 v_to_eye;

vec4 shade() {
    float distance = length(v_to_eye);
    vec3 to_eye = v_to_eye / distance;
    vec3 normal = normalize(v_normal.xyz);
    float facing = dot(normal, to_eye);
    normal = facing < 0.0 ? -normal : normal;
    float edge = 1.0 - min(abs(facing), 1.0);
    float rim = edge * edge * edge;
    float gloss = max(dot(normal, normalize(u_parameters[0].xyz + to_eye)), 0.0);
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    vec3 color = v_color.rgb * daylight(normal, v_normal.w);
    color += (0.8 * gloss * v_normal.w) * u_parameters[2].rgb + rim * u_parameters[3].rgb;
    float alpha = v_color.a + (1.0 - v_color.a) * (0.5 * rim + 0.3 * gloss);
    return vec4(hazed(color, distance), alpha);
}
