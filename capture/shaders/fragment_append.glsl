// Appends every shaded fragment to the output buffer, eight words each, in the layout of ropsim's Fragment.
layout(std430, binding = 0) buffer Output {
    uint count;       // fragments that arrived, also those beyond the capacity
    uint padding[7];  // records are aligned to 32 bytes
    uint words[];
};
flat in uint v_instance;
uniform uint u_capacity;
uniform uint u_primitives;
uniform uint u_first_primitive;

void main() {
    vec4 color = shade();
    float alpha = clamp(color.a, 0.0, 1.0);
    uint slot = atomicAdd(count, 1u);
    if (slot >= u_capacity) return;
    uint at = slot * 8u;
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    words[at] = floatBitsToUint(clamp(gl_FragCoord.z, 0.0, 1.0));
    words[at + 1u] = floatBitsToUint(max(color.r, 0.0) * alpha);
    words[at + 2u] = floatBitsToUint(max(color.g, 0.0) * alpha);
    words[at + 3u] = floatBitsToUint(max(color.b, 0.0) * alpha);
    words[at + 4u] = floatBitsToUint(alpha);
    words[at + 5u] = pixel.x | (pixel.y << 16);
    words[at + 6u] = v_instance * u_primitives + u_first_primitive + uint(gl_PrimitiveID);
}
