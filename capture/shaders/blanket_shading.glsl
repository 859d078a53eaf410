// Woven cloth: a diffuse texture of constant alpha, lit alike on both sides.
in vec3 v_normal;
in vec3 v_to_eye;
in vec2 v_texture;
layout(binding = 0) uniform sampler2D u_pattern;
uniform vec4 u_parameters[8];  // 0: direction towards the light; 1: centre, alpha

vec4 shade() {
    vec3 normal = normalize(v_normal);
    if (dot(normal, v_to_eye) < 0.0) normal = -normal;
    float light = 0.32 + 0.95 * max(dot(normal, u_parameters[0].xyz), 0.0);
    return vec4(texture(u_pattern, v_texture).rgb * light, u_parameters[1].w);
}
