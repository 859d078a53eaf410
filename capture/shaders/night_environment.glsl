// A dark street with a lamp's glow above the horizon, for the lamps' panes.
vec3 environment(vec3 direction) {
    vec3 night = mix(vec3(0.03, 0.028, 0.03), vec3(0.02, 0.03, 0.055), smoothstep(-0.2, 0.6, direction.y));
    float glow = max(dot(direction, normalize(vec3(0.25, -0.3, 0.9))), 0.0);
    return night + vec3(0.35, 0.25, 0.14) * glow * glow * glow * glow;
}
