// Stored samples of colour and depth, in layers of one or more samples each.
#if TARGET_SAMPLES > 1
#define SAMPLES_IN_LAYERS sampler2DMSArray
#else
#define SAMPLES_IN_LAYERS sampler2DArray
#endif
layout(binding = 10) uniform SAMPLES_IN_LAYERS u_sample_depth;
layout(binding = 11) uniform SAMPLES_IN_LAYERS u_sample_color;

vec4 stored_sample(SAMPLES_IN_LAYERS samples, ivec2 pixel, uint s) {
#if TARGET_SAMPLES > 1
    return texelFetch(samples, ivec3(pixel, s / TARGET_SAMPLES), int(s % TARGET_SAMPLES));
#else
    return texelFetch(samples, ivec3(pixel, s), 0);
#endif
}
