// Blending and adaptive transparency as one writes them for a processor: what the benchmarks measure against.
#pragma once

#include "rop/format.h"
#include "traces/fragment.h"

namespace ropsim::test {

// Adaptive transparency with 8 nodes, as one writes it for a processor: find the place, shift, remove.
inline constexpr int kHandWrittenNodes = 8;
struct HandWrittenPixel {
    float node[kHandWrittenNodes][2];  // depth, transmittance
    float color[4];
};

inline void hand_written_insert(HandWrittenPixel& pixel, const Fragment& f) {
    const float t = 1.0f - f.a;
    int at = 0;
    while (at < kHandWrittenNodes && pixel.node[at][0] < f.z) ++at;
    float before = at > 0 ? pixel.node[at - 1][1] : 1.0f;
    if (pixel.node[kHandWrittenNodes - 1][0] == 1e30f) {
        for (int i = kHandWrittenNodes - 1; i > at; --i) {
            pixel.node[i][0] = pixel.node[i - 1][0];
            pixel.node[i][1] = pixel.node[i - 1][1] * t;
        }
        pixel.node[at][0] = f.z;
        pixel.node[at][1] = before * t;
        return;
    }
    float z[kHandWrittenNodes + 1];
    float v[kHandWrittenNodes + 1];
    for (int i = 0; i < at; ++i) {
        z[i] = pixel.node[i][0];
        v[i] = pixel.node[i][1];
    }
    z[at] = f.z;
    v[at] = before * t;
    for (int i = at; i < kHandWrittenNodes; ++i) {
        z[i + 1] = pixel.node[i][0];
        v[i + 1] = pixel.node[i][1] * t;
    }
    int removed = 1;
    float least = (v[0] - v[1]) * (z[1] - z[0]);
    for (int i = 2; i <= kHandWrittenNodes; ++i) {
        const float error = (v[i - 1] - v[i]) * (z[i] - z[i - 1]);
        if (error < least) {
            least = error;
            removed = i;
        }
    }
    v[removed - 1] = v[removed];
    for (int i = 0; i < kHandWrittenNodes; ++i) {
        const int from = i < removed ? i : i + 1;
        pixel.node[i][0] = z[from];
        pixel.node[i][1] = v[from];
    }
}

inline void hand_written_composite(HandWrittenPixel& pixel, const Fragment& f) {
    float visibility = 1.0f;
    for (int i = 0; i < kHandWrittenNodes && pixel.node[i][0] < f.z; ++i) visibility = pixel.node[i][1];
    pixel.color[0] = round_to_float16(pixel.color[0] + visibility * f.r);
    pixel.color[1] = round_to_float16(pixel.color[1] + visibility * f.g);
    pixel.color[2] = round_to_float16(pixel.color[2] + visibility * f.b);
}

inline HandWrittenPixel cleared_pixel() {
    HandWrittenPixel cleared{};
    for (auto& node : cleared.node) {
        node[0] = 1e30f;
        node[1] = 1.0f;
    }
    return cleared;
}

// Over what is there, into a float image.
struct BlendedPixel {
    float rgba[4];
};
inline void hand_written_blend(BlendedPixel& pixel, const Fragment& f) {
    const float t = 1.0f - f.a;
    pixel.rgba[0] = f.r + t * pixel.rgba[0];
    pixel.rgba[1] = f.g + t * pixel.rgba[1];
    pixel.rgba[2] = f.b + t * pixel.rgba[2];
    pixel.rgba[3] = f.a + t * pixel.rgba[3];
}

}  // namespace ropsim::test
