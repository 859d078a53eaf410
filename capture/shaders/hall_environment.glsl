// A light hall as its panes mirror it: behind the viewer a wall with four tall windows, white ceiling, dark
// floor.
vec3 environment(vec3 direction) {
    vec3 wall = mix(vec3(0.12, 0.1, 0.085), vec3(0.5, 0.49, 0.46), smoothstep(-0.5, 0.7, direction.y));
    if (direction.z < 0.05) return wall;
    // Where the ray meets the wall, metres from a point at the height of the eyes.
    vec2 at = direction.xy * (6.5 / direction.z);
    float bay = abs(fract(at.x / 2.6 + 0.25) - 0.5) * 2.6;
    float pane = (1.0 - smoothstep(0.58, 0.62, bay)) * smoothstep(0.02, 0.05, abs(bay)) *
                 (1.0 - smoothstep(1.28, 1.32, abs(at.y - 0.9))) * (1.0 - smoothstep(5.0, 5.4, abs(at.x))) *
                 smoothstep(0.02, 0.06, abs(fract(at.y / 0.86 + 0.45) - 0.5));
    vec3 sky = mix(vec3(1.3, 1.4, 1.4), vec3(1.0, 1.3, 1.8), smoothstep(-0.4, 2.2, at.y));
    return mix(wall, sky, pane);
}
