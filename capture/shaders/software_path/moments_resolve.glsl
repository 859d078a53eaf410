// The accumulated colour, scaled to the pixel's total alpha.
layout(binding = 10) uniform sampler2DArray u_absorbance;
layout(binding = 12) uniform sampler2DArray u_accumulated;

vec3 resolved(ivec2 pixel) {
    float absorbance = texelFetch(u_absorbance, ivec3(pixel, 0), 0).r;
    vec4 sum = texelFetch(u_accumulated, ivec3(pixel, 0), 0);
    float left = absorbance < ABSORBANCE_LIMIT ? exponential(-absorbance) : 0.0;
    precise float scale = sum.a >= uintBitsToFloat(0x00800000u) ? (1.0 - left) / sum.a : 0.0;
    precise vec3 color = sum.rgb * scale + left * texelFetch(u_opaque_color, ivec3(pixel, 0), 0).rgb;
    return color;
}
