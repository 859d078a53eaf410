// A fragment as it arrives at the pixel, whoever draws it: arrival() is defined by arrival_of_geometry or
// arrival_of_replay.
struct Arrival {
    uvec2 pixel;
    float z;             // window depth of the fragment's plane at the pixel's centre
    vec2 slope;          // of that plane, a pixel to the right and down
    vec3 premultiplied;  // linear colour times alpha
    float alpha;
    uint primitive;  // of the draw, instances counted through
    bool back;       // seen from behind
    uint draw;
    uint coverage;  // bit m: spatial sample m
    uint order;     // smaller arrived earlier
    vec3 transmission;
    float collimation;
    float eta;
    vec3 normal;  // camera space
};
Arrival arrival();

layout(binding = 8) uniform sampler2DArray u_opaque_depth;  // layer m: of spatial sample m; infinite where none
layout(binding = 9) uniform sampler2DArray u_opaque_color;
layout(std430, binding = 3) readonly buffer DrawFacts { uint draw_facts[]; };  // 2 object + tested
uniform uint u_samples;              // spatial samples of a pixel
uniform vec4 u_sample_positions[16]; // in pixels from the centre, y down

const uint kBackFacing = 0x80000000u;

// Depth of the fragment's plane at a spatial sample.
float depth_at(Arrival a, uint m) {
    if (u_samples == 1u) return a.z;
    precise float z = a.z + a.slope.x * u_sample_positions[m].x + a.slope.y * u_sample_positions[m].y;
    return clamp(z, 0.0, 1.0);
}
uint object_of(Arrival a) { return draw_facts[a.draw] >> 1; }

// Covered samples in front of the opaque layer.
uint visible_samples(Arrival a) {
    uint visible = a.coverage & ((1u << u_samples) - 1u);
    if ((draw_facts[a.draw] & 1u) == 0u) return visible;
    for (uint m = 0u; m < u_samples; ++m)
        if (!(depth_at(a, m) < texelFetch(u_opaque_depth, ivec3(a.pixel, m), 0).r)) visible &= ~(1u << m);
    return visible;
}
