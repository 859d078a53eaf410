// Eight street lamps: a glow all round and a cone of light below each.
uniform vec4 u_parameters[8];  // place of a lamp, its strength

// Light that arrives at a point from one lamp; `to_lamp` is a unit vector.
vec3 lamp_light(int lamp, vec3 at, out vec3 to_lamp) {
    vec3 way = u_parameters[lamp].xyz - at;
    float distance2 = dot(way, way);
    to_lamp = way * inversesqrt(distance2 + 1e-4);
    float cone = 0.22 + 1.3 * smoothstep(0.52, 0.86, to_lamp.y);
    return vec3(1.0, 0.72, 0.42) * (u_parameters[lamp].w * cone / (0.25 + distance2));
}
