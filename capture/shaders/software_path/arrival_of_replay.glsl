// Fragments of a trace, each drawn as a point.
#define REPLAYED
#define DEPTH_SCALE 0.5
flat in uint v_instance;  // its number in the chunk
layout(std430, binding = 1) readonly buffer Records { uint records[]; };  // 8 words each
#ifdef SLOPES
layout(std430, binding = 2) readonly buffer Slopes { float slopes[]; };
#endif
#if defined(MATERIALS) && defined(READS_MATERIALS)
layout(std430, binding = 4) readonly buffer Materials { float materials[]; };
#endif
uniform uint u_first_arrival;  // number of the chunk's first fragment in the trace

Arrival arrival() {
    uint at = 8u * v_instance;
    Arrival a;
    a.z = uintBitsToFloat(records[at]);
    a.premultiplied = vec3(uintBitsToFloat(records[at + 1u]), uintBitsToFloat(records[at + 2u]),
                           uintBitsToFloat(records[at + 3u]));
    a.alpha = uintBitsToFloat(records[at + 4u]);
    a.pixel = uvec2(records[at + 5u] & 0xFFFFu, records[at + 5u] >> 16);
    a.primitive = records[at + 6u] & ~kBackFacing;
    a.back = (records[at + 6u] & kBackFacing) != 0u;
    a.coverage = records[at + 7u] & 0xFFFFu;
    a.draw = records[at + 7u] >> 16;
    a.order = u_first_arrival + v_instance;
    a.slope = vec2(0.0);
#ifdef SLOPES
    a.slope = vec2(slopes[2u * v_instance], slopes[2u * v_instance + 1u]);
#endif
    a.transmission = vec3(0.0);
    a.collimation = 1.0;
    a.eta = 1.0;
    a.normal = vec3(0.0, 0.0, 1.0);
#if defined(MATERIALS) && defined(READS_MATERIALS)
    a.transmission = vec3(materials[at], materials[at + 1u], materials[at + 2u]);
    a.collimation = materials[at + 3u];
    a.eta = materials[at + 4u];
    a.normal = vec3(materials[at + 5u], materials[at + 6u], materials[at + 7u]);
#endif
    return a;
}
