// Appends every shaded fragment to the output buffer as a record: ropsim's Fragment, then what SLOPES and MATERIALS ask
// for.
layout(std430, binding = 0) buffer Output {
    uint count;       // records that arrived, also those beyond the capacity
    uint padding[7];  // records begin where a Fragment may
    uint words[];
};
flat in uint v_instance;
uniform uint u_capacity;
uniform uint u_primitives;
uniform uint u_first_primitive;
uniform uint u_coverage;  // of this pass: the bit of its sample, or 0 at the pixel's centre
uniform uint u_draw;
uniform mat4 u_view;

#ifdef SLOPES
const uint kMaterialStart = 10u;
#else
const uint kMaterialStart = 8u;
#endif
#ifdef MATERIALS
const uint kRecordWords = kMaterialStart + 8u;
#else
const uint kRecordWords = kMaterialStart;
#endif

void main() {
#ifdef SLOPES
    // Before shade() may discard: derivatives need the whole quad.
    vec2 slope = vec2(dFdx(gl_FragCoord.z), dFdy(gl_FragCoord.z));
#endif
    vec4 color = shade();
    float alpha = clamp(color.a, 0.0, 1.0);
    uint slot = atomicAdd(count, 1u);
    if (slot >= u_capacity) return;
    uint at = slot * kRecordWords;
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    words[at] = floatBitsToUint(clamp(gl_FragCoord.z, 0.0, 1.0));
    words[at + 1u] = floatBitsToUint(max(color.r, 0.0) * alpha);
    words[at + 2u] = floatBitsToUint(max(color.g, 0.0) * alpha);
    words[at + 3u] = floatBitsToUint(max(color.b, 0.0) * alpha);
    words[at + 4u] = floatBitsToUint(alpha);
    words[at + 5u] = pixel.x | (pixel.y << 16);
    words[at + 6u] = v_instance * u_primitives + u_first_primitive + uint(gl_PrimitiveID) +
                     (gl_FrontFacing ? 0u : 0x80000000u);
    words[at + 7u] = u_coverage | (u_draw << 16);
#ifdef SLOPES
    words[at + 8u] = floatBitsToUint(slope.x);
    words[at + 9u] = floatBitsToUint(slope.y);
#endif
#ifdef MATERIALS
    vec3 transmission = clamp(surface_transmission, 0.0, 1.0);
    vec3 normal = surface_normal == vec3(0.0) ? vec3(0.0, 0.0, 1.0) : normalize(mat3(u_view) * surface_normal);
    words[at + kMaterialStart] = floatBitsToUint(transmission.r);
    words[at + kMaterialStart + 1u] = floatBitsToUint(transmission.g);
    words[at + kMaterialStart + 2u] = floatBitsToUint(transmission.b);
    words[at + kMaterialStart + 3u] = floatBitsToUint(clamp(surface_collimation, 0.0, 1.0));
    words[at + kMaterialStart + 4u] = floatBitsToUint(surface_eta);
    words[at + kMaterialStart + 5u] = floatBitsToUint(normal.x);
    words[at + kMaterialStart + 6u] = floatBitsToUint(normal.y);
    words[at + kMaterialStart + 7u] = floatBitsToUint(normal.z);
#endif
}
