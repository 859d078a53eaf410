// Opaque painted surface with some texture to it; follows daylight.glsl.
flat in float v_finish;
in vec4 v_color;
in vec3 v_world;
in vec4 v_normal;
in vec3 v_to_eye;
layout(binding = 0) uniform sampler2D u_noise;

// Position on the surface, metres, along the axis plane it faces most.
vec2 on_surface(vec3 normal) {
    vec3 size = abs(normal);
    if (size.y >= max(size.x, size.z)) return v_world.xz;
    return size.x > size.z ? v_world.zy : v_world.xy;
}

// 1 in the joints between bricks, 0 on them; bricks that are smaller than pixels blend.
float joints(vec2 at) {
    vec2 brick = at / vec2(0.24, 0.08);
    brick.x += 0.5 * mod(floor(brick.y), 2.0);
    vec2 width = fwidth(brick);
    vec2 from_joint = 0.5 - abs(fract(brick) - 0.5);
    vec2 joint = 1.0 - smoothstep(vec2(0.03, 0.08), vec2(0.06, 0.14) + 0.7 * width, from_joint);
    return mix(max(joint.x, joint.y), 0.2, clamp(1.5 * width.y, 0.0, 1.0));
}

vec4 shade() {
    if (v_finish < 0.0) return vec4(v_color.rgb, 1.0);
    float distance = length(v_to_eye);
    vec3 normal = normalize(v_normal.xyz);
    normal = dot(normal, v_to_eye) < 0.0 ? -normal : normal;
    vec2 at = on_surface(normal);
    float fine = texture(u_noise, at * 0.9).r - 0.5;
    float coarse = texture(u_noise, at * 0.061).r - 0.5;
    vec3 color = v_color.rgb;
    if (v_finish == 1.0) {
        color = mix(color * (1.0 + 0.5 * fine), vec3(0.55, 0.52, 0.48), 0.75 * joints(at));
        color *= 1.0 + 0.5 * coarse;
    } else if (v_finish == 2.0) {
        float grain = texture(u_noise, at * 5.3).r - 0.5;
        color *= 1.0 + 0.7 * grain + 0.5 * fine + 0.7 * coarse;
    } else if (v_finish == 0.0) {
        color *= 1.0 + 0.16 * fine + 0.2 * coarse;
    }
    vec3 halfway = normalize(u_parameters[0].xyz + v_to_eye / distance);
    float gloss = v_finish == 3.0 ? 0.5 * pow(max(dot(normal, halfway), 0.0), 60.0) * v_normal.w : 0.0;
    float edge = 1.0 - abs(dot(normal, v_to_eye)) / distance;
    float mirror = v_finish == 3.0 ? 0.05 + 0.5 * edge * edge * edge * edge : 0.0;
    color = color * daylight(normal, v_normal.w) + gloss * u_parameters[2].rgb;
    color = mix(color, u_parameters[3].rgb * (1.2 + 0.8 * reflect(-v_to_eye, normal).y / distance), mirror);
    return vec4(hazed(color, distance), 1.0);
}
