// The mean over spatial samples of what was peeled in front of the opaque layer.
layout(binding = 12) uniform sampler2DArray u_accumulated;  // a layer a sample

vec3 resolved(ivec2 pixel) {
    precise vec3 total = vec3(0.0);
    for (uint m = 0u; m < u_samples; ++m) {
        vec4 sum = texelFetch(u_accumulated, ivec3(pixel, m), 0);
        precise vec3 color = sum.rgb + sum.a * texelFetch(u_opaque_color, ivec3(pixel, m), 0).rgb;
        total = total + color;
    }
    return total * (1.0 / float(u_samples));
}
