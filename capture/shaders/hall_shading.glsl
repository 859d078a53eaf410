// Opaque things in a hall, after its environment: daylight from above and from the viewer's side, and the
// sun on the floor as the panes colour it.
flat in vec4 v_color;  // linear; alpha is the pattern: 0 plain, 1 the floor, 2 chequers, 3 bands, 4 boards
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;
layout(binding = 0) uniform sampler2D u_texture;  // half of what arrives of the sun on the floor
// 0: direction towards the sun; 1: the texture's low x and z, one over its sides
uniform vec4 u_parameters[8];

// -1 and 1 in turns along p, each one long, smooth over a pixel.
float turns(float p, float pixel) {
    float wave = abs(fract(0.5 * p) - 0.5) - 0.25;  // -1/4 to 1/4
    return clamp(2.0 * wave / max(pixel, 1e-5), -1.0, 1.0);
}

float wave(vec2 p) { return sin(p.x) * sin(p.y + 1.7 * sin(0.31 * p.x)); }

vec3 patterned(vec3 pixel) {
    vec3 color = v_color.rgb;
    if (v_color.a > 3.5) {
        float board = floor(v_world.x / 0.3);
        vec2 grain = vec2(v_world.x * 70.0, v_world.y * 4.0 + 13.0 * board);
        color *= 0.9 + 0.06 * wave(grain) + 0.05 * wave(grain * 2.3 + 4.0) + 0.12 * fract(board * 0.618);
    } else if (v_color.a > 2.5) {
        color = mix(color, vec3(0.82, 0.78, 0.68), 0.5 - 0.5 * turns(v_world.y / 0.085, pixel.y / 0.085));
    } else if (v_color.a > 1.5) {
        const float kSide = 0.085;
        vec3 at = (v_world + vec3(0.0, 0.0, 0.001)) / kSide;
        vec3 p = pixel / kSide;
        float sign = turns(at.x, p.x) * turns(at.y, p.y) * turns(at.z, p.z);
        color = mix(color, vec3(0.85), 0.5 + 0.5 * sign);
    } else if (v_color.a > 0.5) {
        const float kSide = 0.5;
        float sign = turns(v_world.x / kSide, pixel.x / kSide) * turns(v_world.z / kSide, pixel.z / kSide);
        float vein = 0.93 + 0.07 * wave(v_world.xz * vec2(9.0, 13.0) + 2.0 * sin(5.0 * v_world.zx));
        color = mix(color, vec3(0.5, 0.48, 0.43), 0.5 + 0.5 * sign) * vein;
    }
    return color;
}

vec4 shade() {
    vec3 pixel = fwidth(v_world);
    vec3 normal = normalize(v_normal);
    vec3 to_eye = normalize(v_to_eye);
    vec3 sun = vec3(1.5, 1.36, 1.12) * max(dot(normal, u_parameters[0].xyz), 0.0);
    vec3 light = mix(vec3(0.2, 0.18, 0.16), vec3(0.5, 0.53, 0.58), 0.5 + 0.5 * normal.y) +
                 vec3(0.34, 0.35, 0.37) * max(normal.z, 0.0);
    if (v_world.y < 0.002) {
        vec2 place = (v_world.xz - u_parameters[1].xy) * u_parameters[1].zw;
        vec3 left = vec3(1.0);
        if (all(lessThan(abs(place - 0.5), vec2(0.5)))) left = 2.0 * textureLod(u_texture, place, 0.0).rgb;
        sun *= left;
        // What keeps the sun away keeps some of the sky away.
        light *= 0.75 + 0.25 * left;
    } else {
        light *= 0.62 + 0.38 * smoothstep(0.0, 0.5, v_world.y);
    }
    float away = 1.0 - max(dot(normal, to_eye), 0.0);
    float gloss = v_color.a == 1.0 || v_color.a == 3.0 ? 0.02 : 0.0;
    float fresnel = gloss * (1.0 + 8.0 * away * away * away * away);
    return vec4(patterned(pixel) * (light + sun) + fresnel * environment(reflect(-to_eye, normal)), 1.0);
}
