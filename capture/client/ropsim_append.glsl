// For any program's fragment shaders: append what they shade to a buffer that libropsim_trace_client turns into a trace
// (docs/capture-your-own.md). GLSL 4.30 and up; paste or #include it after #version. One spatial sample a pixel.
//
// The buffer: 8 words of header, of which the caller sets the first to 0 before drawing, then records of 8 words. Its
// size alone says how many fit.
#ifndef ROPSIM_BINDING
#define ROPSIM_BINDING 0
#endif
layout(std430, binding = ROPSIM_BINDING) coherent buffer RopsimOutput {
    uint ropsim_count;  // records that arrived, also those for which there was no room
    uint ropsim_reserved[7];
    uint ropsim_words[];
};

// Appends the fragment being shaded, `color` straight (not premultiplied), linear; alpha is clamped to [0, 1]. `draw` is
// the number of the draw in the trace, `primitive` counts its triangles through all instances, from any number up:
// gl_InstanceID * triangles + gl_PrimitiveID, or gl_PrimitiveID alone for one instance; below 2^31. Bit 31 of the record
// says that the triangle faces back.
void ropsim_append(vec4 color, uint draw, uint primitive) {
    uint slot = atomicAdd(ropsim_count, 1u);
    if (slot >= uint(ropsim_words.length()) / 8u) return;
    uint at = slot * 8u;
    float alpha = clamp(color.a, 0.0, 1.0);
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    ropsim_words[at] = floatBitsToUint(clamp(gl_FragCoord.z, 0.0, 1.0));
    ropsim_words[at + 1u] = floatBitsToUint(max(color.r, 0.0) * alpha);
    ropsim_words[at + 2u] = floatBitsToUint(max(color.g, 0.0) * alpha);
    ropsim_words[at + 3u] = floatBitsToUint(max(color.b, 0.0) * alpha);
    ropsim_words[at + 4u] = floatBitsToUint(alpha);
    ropsim_words[at + 5u] = pixel.x | (pixel.y << 16);
    ropsim_words[at + 6u] = (primitive & 0x7FFFFFFFu) | (gl_FrontFacing ? 0u : 0x80000000u);
    ropsim_words[at + 7u] = 1u | (draw << 16);  // coverage: the one sample
}
