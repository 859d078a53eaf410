// Opaque things in a room with one window: skylight from the window, sun through its panes, and the coloured
// shadows of the glass on the table.
flat in vec4 v_color;  // linear; alpha is the pattern: 0 plain, 1 chessboard, 2 wood
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;
layout(binding = 0) uniform sampler2D u_texture;  // half of what arrives of the sun on the table
// 0: direction towards the sun; 1: the texture's low x and z, one over its sides
uniform vec4 u_parameters[8];

float wave(vec2 p) { return sin(p.x) * sin(p.y + 1.7 * sin(0.31 * p.x)); }

vec3 patterned() {
    vec3 color = v_color.rgb;
    if (v_color.a > 1.5) {
        float plank = floor(v_world.z / 0.14);
        vec2 grain = vec2(v_world.x * 9.0 + 31.0 * plank, v_world.z * 160.0);
        float streak = 0.5 + 0.25 * wave(grain) + 0.25 * wave(grain * vec2(2.7, 2.1) + 5.0);
        color *= (0.75 + 0.35 * streak) * (0.85 + 0.3 * fract(plank * 0.618));
        color *= 1.0 - 0.5 * smoothstep(0.012, 0.0, abs(fract(v_world.z / 0.14) - 0.5) - 0.485);
    } else if (v_color.a > 0.5) {
        vec2 square = floor(v_world.xz / 0.055);
        bool on_board = max(abs(v_world.x), abs(v_world.z)) < 0.22;
        bool dark = mod(square.x + square.y, 2.0) > 0.5;
        float grain = 0.9 + 0.1 * wave(vec2(v_world.x * 30.0, v_world.z * 400.0) + square * 7.0);
        vec3 field = dark ? vec3(0.2, 0.09, 0.04) : vec3(0.72, 0.55, 0.34);
        color = (on_board ? field : vec3(0.16, 0.07, 0.03)) * grain;
    }
    return color;
}

vec4 shade() {
    vec3 normal = normalize(v_normal);
    vec3 to_window = vec3(-2.2, 1.15, -1.15) - v_world;
    float distance2 = dot(to_window, to_window);
    float facing = 0.25 + 0.75 * dot(normal, to_window) * inversesqrt(distance2);
    float window = max(facing, 0.0) / (0.35 + 0.3 * distance2);
    vec3 light = vec3(0.2, 0.18, 0.16) * (0.75 + 0.25 * normal.y) + vec3(0.5, 0.58, 0.68) * window;

    // The sun is where the ray towards it leaves through a pane.
    vec3 to_sun = u_parameters[0].xyz;
    vec2 at = v_world.zy + to_sun.zy * ((-2.2 - v_world.x) / to_sun.x);
    vec2 uv = vec2((at.x + 1.15) / 0.95, (at.y - 1.15) / 0.85);
    vec2 inside = smoothstep(vec2(1.02), vec2(0.96), abs(uv));
    float bars = smoothstep(0.02, 0.07, abs(uv.x)) * smoothstep(0.02, 0.06, abs(abs(uv.y) - 0.33));
    vec3 sun = vec3(1.9, 1.6, 1.2) * (max(dot(normal, to_sun), 0.0) * inside.x * inside.y * bars);
    if (v_world.y < 0.02 && v_world.y > -0.05) {
        vec2 place = (v_world.xz - u_parameters[1].xy) * u_parameters[1].zw;
        if (all(lessThan(abs(place - 0.5), vec2(0.5)))) sun *= 2.0 * textureLod(u_texture, place, 0.0).rgb;
    }
    return vec4(patterned() * (light + sun), 1.0);
}
