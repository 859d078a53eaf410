// A layer under what has been accumulated: colour, and transmittance of it.
layout(binding = 11) uniform sampler2DArray u_layer;
layout(binding = 12) uniform sampler2DArray u_accumulated;
uniform uint u_layer_index;  // of the spatial sample
layout(location = 0) out vec4 o_sum;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 layer = LAYER(texelFetch(u_layer, ivec3(pixel, 0), 0));
    vec4 sum = texelFetch(u_accumulated, ivec3(pixel, u_layer_index), 0);
    precise float weight = sum.a * layer.a;
    precise vec4 under = vec4(sum.rgb + weight * layer.rgb, sum.a * (1.0 - layer.a));
    o_sum = layer.a > 0.0 ? COLOR(under) : sum;
}
