// A fragment's colour for the blend unit, where it is seen at one spatial sample.
uniform uint u_sample;

bool sources(Arrival a, out vec4 source[TARGETS]) {
    source[0] = vec4(a.premultiplied, a.alpha);
    return (visible_samples(a) & (1u << u_sample)) != 0u;
}
