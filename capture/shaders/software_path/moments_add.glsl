// The moments pass, additive.
bool sources(Arrival a, out vec4 source[TARGETS]) {
    float absorbance = absorbance_of(a.alpha);
    float z = place_of(a.z);
    precise float square = z * z;
    precise vec4 powers = vec4(z, square, z * square, square * square);
    precise vec4 added = absorbance * powers;
    source[0] = vec4(absorbance);
    source[1] = added;
    return visible_samples(a) != 0u;
}
