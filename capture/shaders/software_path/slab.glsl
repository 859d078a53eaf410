// Stochastic layered alpha blending (Wyman 2016, section 2.1): a fragment enters the list with the probability that it
// is seen behind the layers in front of it; equation 1 over numbers of coverage bits.
// No constants: Mesa 22.3 takes the upper half of a product of constants for 0.
uniform uint u_seed_low;
uniform uint u_seed_high;

uint bits_of(float alpha) {
    precise float bits = float(BITS) * alpha + 0.5;
    return uint(bits);
}
// That one of t bits out of BITS is not among s covered ones.
float insertion_probability(uint s, uint t) {
    s = min(s, uint(BITS));
    t = min(t, uint(BITS));
    double hidden = 1.0LF;
#ifdef STRATIFIED
    if (t > s) return 1.0;
    for (uint i = 0u; i < t; ++i) hidden *= double(s - i) / double(uint(BITS) - i);
#else
    double bare = double(uint(BITS) - t) / double(uint(BITS));
    for (uint rest = uint(BITS) - s; rest > 0u; rest /= 2u) {
        if (rest % 2u == 1u) hidden *= bare;
        bare *= bare;
    }
#endif
    return float(1.0LF - hidden);
}
bool enters(Node n, int at) {
#if BITS > 0
    uint own = bits_of(n.alpha);
    if (own == 0u) return false;
    if (LAYERS > 1 && at < LAYERS) {
        uvec2 seed = uvec2(u_seed_low, u_seed_high);
        Arrival a = arrival_of(n);
        uvec2 key = fragment_key(seed, uvec2(a.draw, 0u), a.pixel.y * u_width + a.pixel.x, a.primitive);
        uint covered = bits_of(1.0 - transmittance_of_layers(at));
        if (!(random_unit(key, 0u) < insertion_probability(covered, own))) return false;
    }
#endif
    return at < LAYERS;
}

vec3 resolved(ivec2 pixel) {
    clear_layers();
    float clear = 1.0;
    for (uint n = first_node(pixel); n != 0u; n = node(n).next) {
        Node f = node(n);
        precise float dimmed = clear * (1.0 - f.alpha);
        clear = TOTAL_ALPHA(dimmed);
        int at = layers_before(f.z);
        if (enters(f, at)) insert_layer(at, f.z, LAYER(vec4(premultiplied_of(f), f.alpha)));
    }
    vec3 background = background_of(pixel);
#ifdef COMPOSITE_direct
    return over_background(composited_layers(), background);
#else
    vec4 sum = vec4(0.0);
    for (uint n = first_node(pixel); n != 0u; n = node(n).next) {
        float seen = transmittance_of_layers(layers_in_front(node(n).z));
        if (!(seen > 0.0)) continue;
        precise vec4 more = sum + seen * vec4(premultiplied_of(node(n)), node(n).alpha);
        sum = ACCUMULATION(more);
    }
#ifdef COMPOSITE_accumulated
    return over_background(vec4(sum.rgb, transmittance_of_layers(LAYERS)), background);
#else
    precise float scale = sum.a > 0.0 ? (1.0 - clear) / sum.a : 0.0;
    precise vec3 color = sum.rgb * scale + clear * background;
    return color;
#endif
#endif
}
