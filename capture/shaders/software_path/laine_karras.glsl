// Stratified stochastic transparency (Laine and Karras 2011, figures 4 and 7): surfaces are tracked, samples that a
// fragment is not hidden in are compacted and sorted by stored depth, and each takes the next opacity reference.
// No constants: Mesa 22.3 takes the upper half of a product of constants for 0.
uniform uint u_seed_low;
uniform uint u_seed_high;

float stored_z[STORED];
vec3 stored_color[STORED];
uvec2 tracked;  // samples drawn of the current surface
uint surface;

void clear_samples(ivec2 pixel) {
    tracked = uvec2(0u);
    surface = 0u;
    for (uint s = 0u; s < STORED; ++s) {
#ifdef DEPTH_BASED
        stored_z[s] = uintBitsToFloat(0x7F800000u);
        stored_color[s] = vec3(0.0);
#else
        ivec3 place = ivec3(pixel, s % SAMPLES);
        stored_z[s] = texelFetch(u_opaque_depth, place, 0).r;
        stored_color[s] = COLOR(vec4(texelFetch(u_opaque_color, place, 0).rgb, 1.0)).rgb;
#endif
    }
}
uint first_reference(Arrival a) {
#ifdef INDEX_hilbert
    uint index = hilbert_index(HILBERT_ORDER, a.pixel);
#else
    uint index = morton_index(a.pixel);
#endif
    uvec2 seed = uvec2(u_seed_low, u_seed_high);
    if (seed != uvec2(0u)) index += mix64(seed).x;
    return index * STORED;
}

void draw_fragment(Arrival a) {
    uvec2 covered = uvec2(0u);
    uvec2 survivors = uvec2(0u);
    for (uint s = 0u; s < STORED; ++s) {
        if ((a.coverage >> (s % SAMPLES) & 1u) == 0u) continue;
        covered = mask_with(covered, s);
        if (depth_at(a, s % SAMPLES) <= stored_z[s]) survivors = mask_with(survivors, s);
    }
    if (survivors == uvec2(0u)) return;
#ifdef COMPACTION
    uvec2 drawn = survivors;
#else
    uvec2 drawn = covered;
#endif
    uint first = 0u;
#ifdef TRACKING
    if ((tracked & drawn) != uvec2(0u)) {
        ++surface;
        tracked = uvec2(0u);
    }
    first = mask_count(tracked);
    tracked |= drawn;
#else
    ++surface;
#endif
    uint order[STORED];
    uint count = 0u;
    for (uint s = 0u; s < STORED; ++s) {
        if (!mask_has(survivors, s)) continue;
        uint at = count++;
#ifdef SORT
        for (; at > 0u && stored_z[order[at - 1u]] > stored_z[s]; --at) order[at] = order[at - 1u];
#endif
        order[at] = s;
    }
    precise float inverse = a.alpha > 0.0 ? 1.0 / a.alpha : 0.0;
    precise vec3 straight = a.premultiplied * inverse;
    vec3 color = COLOR(vec4(straight, 1.0)).rgb;
    uint base = first_reference(a);
    for (uint k = 0u; k < count; ++k) {
        uint s = order[k];
#ifdef COMPACTION
        uint number = first + k;
#else
        uint number = s;
#endif
        if (!below_alpha(opacity_reference(base + number, surface), a.alpha)) continue;
        stored_z[s] = depth_at(a, s % SAMPLES);
        stored_color[s] = color;
    }
}

vec3 resolved(ivec2 pixel) {
    clear_samples(pixel);
    for (uint n = first_node(pixel); n != 0u; n = node(n).next) draw_fragment(arrival_of(node(n)));
#ifdef DEPTH_BASED
    vec4 sum = vec4(0.0);
    float clear = 1.0;
    for (uint n = first_node(pixel); n != 0u; n = node(n).next) {
        Arrival a = arrival_of(node(n));
        vec4 color = vec4(a.premultiplied, a.alpha);
        precise float dimmed = clear * (1.0 - a.alpha);
        clear = TOTAL_ALPHA(dimmed);
        uint seen = 0u;
        for (uint s = 0u; s < STORED; ++s)
            if (a.z <= stored_z[s]) ++seen;
        precise vec4 more = sum + (float(seen) / float(STORED)) * color;
        if (seen > 0u) sum = ACCUMULATION(more);
    }
    precise float scale = sum.a > 0.0 ? (1.0 - clear) / sum.a : 0.0;
    precise vec3 result = sum.rgb * scale + clear * background_at(pixel, 0u);
    return result;
#else
    for (uint stride = 1u; stride < STORED; stride *= 2u)
        for (uint s = 0u; s + stride < STORED; s += 2u * stride) {
            precise vec3 pair = stored_color[s] + stored_color[s + stride];
            stored_color[s] = pair;
        }
    precise vec3 mean = stored_color[0] * (1.0 / float(STORED));
    return mean;
#endif
}
