// Opaque things in a street at night, after street_light.
flat in vec4 v_color;  // linear; alpha is the pattern: 0 plain, 1 cobbles, 2 a house front, 3 a flame
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;

float random(vec2 p) { return fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.547); }

// Colour and, in alpha, how wet it is.
vec4 cobbles() {
    vec2 at = v_world.xz / vec2(0.22, 0.16);
    at.x += 0.5 * mod(floor(at.y), 2.0);
    vec2 stone = floor(at);
    vec2 inside = abs(fract(at) - 0.5);
    float gap = smoothstep(0.36, 0.5, max(inside.x, inside.y));
    vec3 color = v_color.rgb * (0.6 + 0.6 * random(stone)) * (1.0 - 0.75 * gap);
    return vec4(color, (0.5 + 0.5 * random(stone + 3.0)) * (1.0 - gap));
}

vec3 house_front(vec3 normal, out vec3 shine) {
    float along = abs(normal.x) > 0.5 ? v_world.z : v_world.x;
    vec2 at = vec2(along / 1.9, (v_world.y - 0.9) / 2.7);
    vec2 cell = floor(at);
    vec2 p = fract(at) - 0.5;
    shine = vec3(0.0);
    float course = floor(v_world.y / 0.08);
    float brick = random(vec2(floor(along / 0.24 + 0.5 * mod(course, 2.0)), course));
    vec3 color = v_color.rgb * (0.85 + 0.15 * brick);
    if (abs(p.y - 0.47) < 0.03) color *= 1.5;
    if (cell.y < 0.0) return color;
    if (abs(p.x) < 0.3 && abs(p.y + 0.04) < 0.34) color *= 1.35;
    if (abs(p.x) < 0.25 && abs(p.y + 0.04) < 0.3) {
        bool bar = min(abs(p.x), abs(p.y - 0.06)) < 0.02;
        color = bar ? vec3(0.1) : vec3(0.012, 0.014, 0.02);
        float lit = random(cell + floor(v_color.b * 977.0));
        // Curtains darken the upper part.
        vec3 lamp = mix(vec3(0.75, 0.45, 0.16), vec3(0.85, 0.66, 0.36), lit);
        if (!bar && lit > 0.78) shine = lamp * (0.5 + 0.5 * smoothstep(0.3, -0.3, p.y));
    }
    return color;
}

vec4 shade() {
    if (v_color.a > 2.5) return vec4(v_color.rgb, 1.0);
    vec3 normal = normalize(v_normal);
    vec3 to_eye = normalize(v_to_eye);
    vec3 color = v_color.rgb;
    vec3 shine = vec3(0.0);
    float wet = 0.05;
    if (v_color.a > 1.5) {
        color = house_front(normal, shine);
    } else if (v_color.a > 0.5) {
        vec4 ground = cobbles();
        color = ground.rgb;
        wet = ground.a;
    }
    vec3 light = vec3(0.018, 0.024, 0.04) * (1.0 + 0.5 * normal.y);
    vec3 mirrored = vec3(0.0);
    for (int i = 0; i < 8; ++i) {
        vec3 to_lamp;
        vec3 arrives = lamp_light(i, v_world, to_lamp);
        light += arrives * max(dot(normal, to_lamp), 0.0);
        mirrored += arrives * pow(max(dot(normal, normalize(to_lamp + to_eye)), 0.0), 60.0);
    }
    return vec4(color * light + wet * mirrored + shine, 1.0);
}
