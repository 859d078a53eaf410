// Means over a pixel's spatial samples, in pairs.
vec3 mean_of_samples(vec3 color[SAMPLES]) {
    for (uint stride = 1u; stride < SAMPLES; stride *= 2u)
        for (uint m = 0u; m + stride < SAMPLES; m += 2u * stride) {
            precise vec3 sum = color[m] + color[m + stride];
            color[m] = sum;
        }
    precise vec3 mean = color[0] * (1.0 / float(SAMPLES));
    return mean;
}
vec3 background_at(ivec2 pixel, uint m) { return texelFetch(u_opaque_color, ivec3(pixel, m), 0).rgb; }
bool covers(Node n, uint m) { return (coverage_of(n) >> m & 1u) != 0u; }
// Several samples' coverage stands in a list's depths, in their lowest bits.
float listed_depth(float z) {
#if SAMPLES > 1u
    return uintBitsToFloat(floatBitsToUint(z) & ~((1u << SAMPLES) - 1u));
#else
    return z;
#endif
}
