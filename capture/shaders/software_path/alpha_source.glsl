// Alpha alone, for a target of total transmittance.
bool sources(Arrival a, out vec4 source[TARGETS]) {
    source[0] = vec4(a.alpha);
    return visible_samples(a) != 0u;
}
