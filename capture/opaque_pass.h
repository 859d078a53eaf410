// Draws that go through the ordinary pipeline: the opaque layer behind the fragments, and counts of layers.
#pragma once

#include "capture/scene.h"
#include "traces/trace.h"

#include <cstdint>

namespace ropsim {

// Draws the opaque geometry with a float depth test, every spatial sample by itself at its position of
// sample_positions(), shaded there. Needs a current GlContext.
OpaqueLayer draw_opaque_layer(const Scene& scene, int width, int height, int samples);

struct LayerCounts {
    std::uint64_t fragments = 0;  // transparent, all layers
    std::uint64_t covered = 0;    // pixels with any
    std::uint64_t deepest = 0;    // layers of the deepest pixel

    double mean_layers() const {
        return covered == 0 ? 0.0 : static_cast<double>(fragments) / static_cast<double>(covered);
    }
};

// Counts the transparent layers of every pixel (exact up to 2^24 a pixel) without capturing them.
LayerCounts count_layers(const Scene& scene, int width, int height);

}  // namespace ropsim
