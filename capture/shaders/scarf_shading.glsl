// Sheer cloth: threads cover, gaps between them let through; denser where seen edge-on, lit through from
// behind.
in vec4 v_normal;
in vec3 v_to_eye;
in vec3 v_weave;
layout(binding = 0) uniform sampler2D u_texture;  // how much a thread crossing covers
uniform vec4 u_parameters[8];  // 0: direction towards the light; 1: colour; 2: colour of the stripes

vec4 shade() {
    vec3 normal = normalize(v_normal.xyz);
    float facing = abs(dot(normal, normalize(v_to_eye)));
    float cover = texture(u_texture, v_weave.xy).r;
    float sun = dot(normal, u_parameters[0].xyz);
    float same_side = sun * dot(normal, v_to_eye) > 0.0 ? 1.0 : 0.6;
    float stripe = smoothstep(0.35, 0.45, abs(fract(7.0 * v_weave.z) - 0.5));
    vec3 color = mix(u_parameters[1].rgb, u_parameters[2].rgb, stripe);
    float light = 0.32 + 0.75 * v_normal.w * same_side * abs(sun);
    float alpha = 1.0 - pow(1.0 - cover, 1.0 / max(facing, 0.2));
    return vec4(color * light, alpha);
}
