// A long courtyard between two palace fronts, as seen from a table in its middle: arcades, rows of windows,
// an arch at either end, a strip of sky.
vec3 sky(vec3 direction) {
    return mix(vec3(2.1, 2.2, 2.2), vec3(0.75, 1.25, 2.2), smoothstep(0.1, 0.9, direction.y));
}

// `along` the wall, `y` above the table, metres; blurred more with `distance`.
vec3 front(float along, float y, float distance) {
    float blur = 0.02 + 0.012 * distance;
    float bay = abs(fract(along / 3.2) - 0.5) * 3.2;
    vec3 stone = vec3(0.72, 0.62, 0.47);
    float arch = sqrt(max(1.0 - 0.8 * bay * bay, 0.0)) + 2.1;
    float open = smoothstep(blur, -blur, bay - 1.1) * smoothstep(blur, -blur, y - arch);
    stone = mix(stone, vec3(0.07, 0.06, 0.055), open);
    for (int floor = 0; floor < 2; ++floor) {
        float v = y - 5.2 - 2.9 * float(floor);
        float pane = smoothstep(blur, -blur, bay - 0.5) * smoothstep(blur, -blur, abs(v) - 0.85);
        float frame = smoothstep(blur, -blur, bay - 0.72) * smoothstep(blur, -blur, abs(v - 0.1) - 1.1);
        stone = mix(mix(stone, vec3(0.46, 0.45, 0.44), frame), vec3(0.09, 0.1, 0.12), pane);
    }
    float ledge = smoothstep(0.14 + blur, 0.14 - blur, abs(y - 3.7)) +
                  smoothstep(0.2 + blur, 0.2 - blur, abs(y - 9.9));
    return mix(stone, vec3(0.85, 0.78, 0.65), min(ledge, 1.0));
}

vec3 environment(vec3 direction) {
    vec3 d = direction + vec3(1e-5);
    float side = 6.0 / abs(d.x);
    float end = 38.0 / abs(d.z);
    float ground = d.y < 0.0 ? 0.95 / -d.y : 1e6;
    float nearest = min(min(side, end), ground);
    vec3 at = d * nearest;
    if (nearest == ground) {
        float blur = 0.01 + 0.02 * nearest;
        vec2 joint = abs(fract(at.xz / 1.6) - 0.5);
        float lines = smoothstep(0.5 - 0.02 - blur, 0.5, max(joint.x, joint.y)) / (1.0 + 30.0 * blur);
        float sunny = smoothstep(-0.6, -1.2, at.x);
        return vec3(0.36, 0.33, 0.29) * (1.0 - 0.5 * lines) * mix(0.55, 1.5, sunny);
    }
    if (at.y > 10.2) return sky(direction);
    if (nearest == side) {
        // The sun stands over the right-hand palace: the left one is lit down to its arcade.
        vec3 light = d.x < 0.0 ? mix(vec3(0.5, 0.55, 0.62), vec3(1.5, 1.3, 1.0), smoothstep(1.4, 2.4, at.y))
                               : vec3(0.42, 0.47, 0.55);
        return front(at.z, at.y, nearest) * light;
    }
    float opening = length(vec2(at.x, max(at.y - 4.0, 0.0)));
    if (opening < 2.6) return mix(vec3(0.72, 0.8, 0.9), vec3(0.55, 0.55, 0.5), smoothstep(1.5, -1.0, at.y));
    return front(at.x + 1.6, at.y, nearest) * vec3(0.62, 0.6, 0.58);
}
