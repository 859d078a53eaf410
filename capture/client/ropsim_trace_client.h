// Writes fragment traces from any program that owns its shaders (docs/capture-your-own.md): plain C99, no
// OpenGL.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct RopsimTrace RopsimTrace;

// Zero-initialised members mean what they say after "0:".
typedef struct RopsimTraceInfo {
    int width;            // pixels, 1 to 16384
    int height;           // likewise
    int samples;          // spatial samples a pixel: 1, 2, 4, 8 or 16; records need 1. 0: 1
    int bottom_up;        // 1: rows of records, fragments and opaque layer count from the bottom, as OpenGL's
                          // windows; 0: from the top
    int half_colors;      // 1: colours are rounded to 16-bit floats, which halves the file; 0: 32-bit
    float background[3];  // linear
    const char* scene;    // one line on what it shows. 0: nothing
} RopsimTraceInfo;

typedef struct RopsimCamera {
    float view[16];        // world to camera, column-major like OpenGL
    float projection[16];  // camera to clip
    float near_plane;      // camera-space distances, scene units
    float far_plane;
    float fovy_degrees;     // 0 for an orthographic camera
    float metres_per_unit;  // 0: 1
} RopsimCamera;

typedef struct RopsimShaderCost {
    uint32_t alu_instructions;
    uint32_t texture_fetches;
    uint32_t texture_bytes;
} RopsimShaderCost;

typedef enum RopsimBlend { kRopsimOver, kRopsimAdditive, kRopsimMultiply } RopsimBlend;
typedef enum RopsimCull { kRopsimCullNone, kRopsimCullBack, kRopsimCullFront } RopsimCull;

typedef struct RopsimDraw {
    const char* name;  // one line. 0: "draw N"
    int depth_test;    // 1: tested against the opaque layer
    int depth_write;
    RopsimBlend blend;
    RopsimCull cull;
    RopsimShaderCost full;   // of a fragment of the whole shader
    RopsimShaderCost alpha;  // of what remains of it when only alpha is wanted
    const char*
        cost_source;  // where the two come from. 0: the trace's defaults, and the costs above are not read
} RopsimDraw;

// A fragment as the trace stores it; colours linear, premultiplied by alpha.
typedef struct RopsimFragment {
    float z;  // window depth, 0 to 1
    float r, g, b;
    float a;             // 0 to 1
    uint16_t x, y;       // pixel
    uint32_t primitive;  // triangle within the draw, below 2^31; plus 0x80000000 where it faces back
    uint16_t coverage;   // bit m: sample m
    uint16_t draw;       // number that ropsim_trace_add_draw() gave
} RopsimFragment;

// Starts a trace that appears under `path` when ropsim_trace_finish() succeeds. Null only without memory:
// other faults show at the first call that can report them.
RopsimTrace* ropsim_trace_create(const char* path, const RopsimTraceInfo* info);

// All functions below that return int: 0 where done, else 1 with ropsim_trace_error() saying why in one line.
// After a failure all further calls fail with the same error. None throws, none ends the process for what it
// was given.

// Before the first append. The opaque layer: width * height * samples * 3 linear colours and as many / 3
// depths (0 to 1, INFINITY where nothing opaque was drawn), copied.
int ropsim_trace_set_camera(RopsimTrace* trace, const RopsimCamera* camera);
int ropsim_trace_set_light(RopsimTrace* trace, const RopsimCamera* light);
int ropsim_trace_set_opaque(RopsimTrace* trace, const float* rgb, const float* depth);
// Also sets *number (may be null) to the draw's: 0, 1, 2, ...
int ropsim_trace_add_draw(RopsimTrace* trace, const RopsimDraw* draw, uint32_t* number);

// Records that did not fit into `buffer`, `bytes` of what ropsim_append.glsl wrote; 0: all are there. Draw
// fewer triangles at once, or give a larger buffer, and draw again.
uint64_t ropsim_records_lost(const void* buffer, size_t bytes);
// Appends the records of a buffer in the order in which a rasteriser would have sent them, whatever order the
// GPU appended in: by draw, triangle, 8x8 tile, 2x2 quad, pixel. Fails where records were lost. Triangle
// numbers of one draw in one buffer may span at most 2^24.
int ropsim_trace_append_records(RopsimTrace* trace, const void* buffer, size_t bytes);
// Appends fragments in the order given.
int ropsim_trace_append_fragments(RopsimTrace* trace, const RopsimFragment* fragments, size_t count);

// Completes the file. Nothing may be appended afterwards.
int ropsim_trace_finish(RopsimTrace* trace);
// "" while there was no failure; lives as long as `trace`.
const char* ropsim_trace_error(const RopsimTrace* trace);
// Frees; a trace that was not finished is abandoned and leaves no file. Null is allowed.
void ropsim_trace_free(RopsimTrace* trace);

#ifdef __cplusplus
}
#endif
