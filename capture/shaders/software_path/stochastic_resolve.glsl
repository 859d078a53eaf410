// From stored samples, and what was accumulated over them, to the image (Enderton et al. 2011, 3.3, 3.4 and 4).
layout(binding = 12) uniform sampler2DArray u_total;
layout(binding = 13) uniform sampler2DArray u_accumulated;

// Neighbours first, then their sums, so that 64 samples lose no more than 6 roundings.
vec4 mean_of_samples(ivec2 pixel) {
    precise vec4 sums[7];  // of 2^i samples, where bit i of how many there were is set
    for (uint s = 0u; s < STORED_SAMPLES; ++s) {
        precise vec4 sum = stored_sample(u_sample_color, pixel, s);
#ifdef COLOR_CODES
        sum = kept_unorm8(sum);
#endif
        uint i = 0u;
        for (; (s >> i & 1u) != 0u; ++i) sum = sums[i] + sum;
        sums[i] = sum;
    }
    precise vec4 total = vec4(0.0);
    for (uint i = 0u; i < 7u; ++i)
        if ((STORED_SAMPLES >> i & 1u) != 0u) total = sums[i] + total;
    return total / float(STORED_SAMPLES);
}
float empty_share(ivec2 pixel) {
    uint empty = 0u;
    for (uint s = 0u; s < STORED_SAMPLES; ++s)
        if (stored_sample(u_sample_depth, pixel, s).r >= 1.0) ++empty;
    return float(empty) / float(STORED_SAMPLES);
}

vec3 resolved(ivec2 pixel) {
#if !defined(DEPTH_BASED) && defined(CORRECTION_none)
    return mean_of_samples(pixel).rgb;
#else
    vec3 background = texelFetch(u_opaque_color, ivec3(pixel, 0), 0).rgb;
#ifdef DEPTH_BASED
    vec4 sum = texelFetch(u_accumulated, ivec3(pixel, 0), 0);
#else
    vec4 sum = mean_of_samples(pixel);
#endif
#ifdef CORRECTION_none
    precise vec3 uncorrected = sum.rgb + empty_share(pixel) * background;
    return uncorrected;
#else
    float clear = texelFetch(u_total, ivec3(pixel, 0), 0).r;
#if defined(DEPTH_BASED) && defined(CORRECTION_coverage)
    float weight = 1.0 - empty_share(pixel);
#else
    float weight = sum.a;
#endif
    precise float factor = weight > 0.0 ? (1.0 - clear) / weight : 0.0;
    precise vec3 color = sum.rgb * factor + background * clear;
    return color;
#endif
#endif
}
