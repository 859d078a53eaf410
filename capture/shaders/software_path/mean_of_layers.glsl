// Mean of a target's layers, one a spatial sample.
layout(binding = 10) uniform sampler2DArray u_layers;

vec3 resolved(ivec2 pixel) {
    precise vec3 sum = vec3(0.0);
    for (uint m = 0u; m < u_samples; ++m) sum += texelFetch(u_layers, ivec3(pixel, m), 0).rgb;
    return sum / float(u_samples);
}
