// Transparency by a map of visibility (Salvi et al. 2011, section 4): a pass over the pixel's fragments for the depths
// that it lies between, one that adds to it, one that composites with it.
float kept_unorm16(float value) {
    precise float code = floor(clamp(value, 0.0, 1.0) * 65535.0 + 0.5);
    precise float kept = code / 65535.0;
    return kept;
}

#ifdef VARIABLE
// From lists, the latest arrival first, without rounding.
uint listed(uint first) { return reversed(first); }
vec4 color_of(Node n) { return LIST_COLOR(vec4(premultiplied_of(n), n.alpha)); }
float depth_of(Node n, uint m) { return listed_depth(n.z); }
#else
uint listed(uint first) { return first; }
vec4 color_of(Node n) { return vec4(premultiplied_of(n), n.alpha); }
float depth_of(Node n, uint m) { return depth_at(arrival_of(n), m); }
#endif

// Where depth z stands from the nearest to the furthest.
float share_of(float z, float nearest, float furthest) {
#ifdef BOUNDS_frame
    return z;
#else
    precise float extent = furthest - nearest;
    precise float share = (z - nearest) / (extent > 0.0 ? extent : 1.0);
    return clamp(share, 0.0, 1.0);
#endif
}

vec3 sample_color(uint first, ivec2 pixel, uint m) {
    float nearest = 1e30;
    float furthest = -1e30;
    for (uint n = first; n != 0u; n = node(n).next) {
        if (!covers(node(n), m)) continue;
        nearest = min(nearest, depth_of(node(n), m));
        furthest = max(furthest, depth_of(node(n), m));
    }
    for (int i = 0; i < CELLS; ++i) cell[i] = 0.0;
    for (uint n = first; n != 0u; n = node(n).next)
        if (covers(node(n), m))
            add_to_map(share_of(depth_of(node(n), m), nearest, furthest), color_of(node(n)).a);
    vec4 sum = vec4(0.0);
    float total = 1.0;
    for (uint n = first; n != 0u; n = node(n).next) {
        if (!covers(node(n), m)) continue;
        vec4 color = color_of(node(n));
        precise vec4 more = sum + map_visibility(share_of(depth_of(node(n), m), nearest, furthest)) * color;
        sum = COLOR(more);
        precise float dimmed = total * (1.0 - color.a);
        total = TOTAL(dimmed);
    }
    precise vec3 color = sum.rgb;
#ifdef NORMALISED
    const float kLeast = uintBitsToFloat(0x38800000u);  // 2^-14
    precise float scale = sum.a >= kLeast ? (1.0 - total) / sum.a : 1.0;
    color = color * scale;
#endif
    color = color + total * background_at(pixel, m);
    return color;
}

vec3 resolved(ivec2 pixel) {
    uint first = listed(first_node(pixel));
    vec3 color[SAMPLES];
    for (uint m = 0u; m < SAMPLES; ++m) color[m] = sample_color(first, pixel, m);
    return IMAGE(vec4(mean_of_samples(color), 1.0)).rgb;
}
