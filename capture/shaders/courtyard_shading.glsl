// Opaque things in a courtyard, after its environment: the courtyard itself, a table, caps and labels.
flat in vec4 v_color;  // linear; alpha is the pattern: 0 plain, 1 wood, 2 a label, 3 the courtyard itself
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;
layout(binding = 0) uniform sampler2D u_texture;  // half of what arrives of the sun on the table
// 0: direction towards the sun; 1: the texture's low x and z, one over its sides
uniform vec4 u_parameters[8];

float wave(vec2 p) { return sin(p.x) * sin(p.y + 1.7 * sin(0.31 * p.x)); }

vec4 shade() {
    if (v_color.a > 2.5) return vec4(environment(normalize(-v_to_eye)), 1.0);
    vec3 normal = normalize(v_normal);
    vec3 to_eye = normalize(v_to_eye);
    vec3 color = v_color.rgb;
    float gloss = 0.04;
    if (v_color.a > 1.5) {
        // Bands and a row of lozenges.
        float y = fract((v_world.y - 0.085) / 0.09 + 0.5);
        float around = atan(v_normal.z, v_normal.x) * 3.0;
        float band = step(abs(y - 0.5), 0.3);
        float lozenge = step(abs(fract(around) - 0.5) * 0.55 + abs(y - 0.5), 0.2);
        color = mix(color, vec3(0.9, 0.88, 0.82), band * (1.0 - lozenge));
    } else if (v_color.a > 0.5) {
        float plank = floor(v_world.x / 0.11);
        vec2 grain = vec2(v_world.x * 210.0, v_world.z * 11.0 + 13.0 * plank);
        color *= 0.8 + 0.15 * wave(grain) + 0.1 * wave(grain * 2.3 + 4.0) + 0.16 * fract(plank * 0.618);
        color *= 1.0 - 0.55 * smoothstep(0.485, 0.5, abs(fract(v_world.x / 0.11) - 0.5));
        gloss = 0.02;
    }
    vec3 sun = vec3(2.2, 1.95, 1.6) * max(dot(normal, u_parameters[0].xyz), 0.0);
    if (v_world.y < 0.001) {
        vec2 place = (v_world.xz - u_parameters[1].xy) * u_parameters[1].zw;
        if (all(lessThan(abs(place - 0.5), vec2(0.5)))) sun *= 2.0 * textureLod(u_texture, place, 0.0).rgb;
    }
    vec3 light = mix(vec3(0.2, 0.19, 0.18), vec3(0.42, 0.5, 0.62), 0.5 + 0.5 * normal.y) + sun;
    float away = 1.0 - max(dot(normal, to_eye), 0.0);
    float fresnel = gloss + 0.5 * gloss * away * away * away * 8.0;
    return vec4(color * light + fresnel * environment(reflect(-to_eye, normal)), 1.0);
}
