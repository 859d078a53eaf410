// Colour times the share of samples in which the fragment is not hidden (Enderton et al. 2011, equations 4 and 6).
bool sources(Arrival a, out vec4 source[TARGETS]) {
    uint seen = 0u;
    for (uint s = 0u; s < STORED_SAMPLES; ++s)
        if (DEPTH_SCALE * a.z <= stored_sample(u_sample_depth, ivec2(a.pixel), s).r) ++seen;
    precise float visibility = float(seen) / float(STORED_SAMPLES);
    precise vec4 seen_color = visibility * vec4(a.premultiplied, a.alpha);
    source[0] = seen_color;
    return visible_samples(a) != 0u && seen > 0u;
}
