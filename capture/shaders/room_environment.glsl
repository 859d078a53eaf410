// A room as seen from the middle of its table: a tall window of six panes in the left wall, warm walls, dark
// floor.
vec3 environment(vec3 direction) {
    vec3 wall = mix(vec3(0.16, 0.11, 0.075), vec3(0.5, 0.46, 0.4), smoothstep(-0.35, 0.6, direction.y));
    if (direction.x > -0.05) return wall;
    // Where the ray meets the window's wall: u along it, v up, -1 to 1 over the window.
    vec2 at = direction.zy * (-2.2 / direction.x);
    vec2 uv = vec2((at.x + 1.15) / 0.95, (at.y - 1.15) / 0.85);
    vec2 frame = smoothstep(vec2(1.0), vec2(0.95), abs(uv));
    float bars = smoothstep(0.03, 0.07, abs(uv.x)) * smoothstep(0.03, 0.06, abs(abs(uv.y) - 0.33));
    vec3 sky = mix(vec3(4.2, 4.3, 4.2), vec3(3.0, 4.0, 5.6), smoothstep(-0.8, 1.0, uv.y));
    return mix(wall, sky, frame.x * frame.y * bars);
}
