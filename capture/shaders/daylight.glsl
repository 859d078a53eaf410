// Sun, sky and haze that every surface of an outdoor scene shares.
uniform vec4 u_parameters[8];  // 0: towards the sun; 1: haze colour, extinction a metre; 2: sunlight; 3: skylight

// Light on a surface of this normal: the sun's share that arrives, a sky overhead, a darker ground below.
vec3 daylight(vec3 normal, float sun) {
    float facing = max(dot(normal, u_parameters[0].xyz), 0.0) * sun;
    return u_parameters[2].rgb * facing + u_parameters[3].rgb * (0.7 + 0.3 * normal.y);
}

vec3 hazed(vec3 color, float distance) {
    return mix(u_parameters[1].rgb, color, exp(-u_parameters[1].w * distance));
}
