// The mean colour over the background, by revealage (McGuire and Bavoil 2013, their sample's mending of overflow).
layout(binding = 10) uniform sampler2DArray u_accumulated;
layout(binding = 11) uniform sampler2DArray u_revealage;

vec3 mean_background(ivec2 pixel) {
    precise vec3 sum = vec3(0.0);
    for (uint m = 0u; m < u_samples; ++m) sum += texelFetch(u_opaque_color, ivec3(pixel, m), 0).rgb;
    return sum / float(u_samples);
}

vec3 resolved(ivec2 pixel) {
    vec4 sum = texelFetch(u_accumulated, ivec3(pixel, 0), 0);
    float revealage = texelFetch(u_revealage, ivec3(pixel, 0), 0).r;
#ifdef REVEALAGE_CODES
    revealage = kept_unorm8(revealage);
#endif
    precise float shown = 1.0 - revealage;
    float divisor = isinf(sum.a) ? max(max(sum.r, sum.g), sum.b) : sum.a;
    precise float scale = shown / max(divisor, 1e-7);
    precise vec3 mean = sum.rgb * scale;
    if (any(isinf(sum.rgb)) || any(isnan(sum.rgb))) mean = vec3(shown);
    precise vec3 color = mean + revealage * mean_background(pixel);
    return color;
}
