// Seeded synthetic traces for tests, demonstrations and benchmarks.
#pragma once

#include "traces/trace.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// Independent random fragments over a small image.
struct RandomFragments {
    std::uint64_t seed = 1;
    int width = 32;  // 1..16384
    int height = 32;
    int samples = 1;
    std::uint64_t count = 10000;
    float alpha_low = 0.0f;  // alpha is uniform in [alpha_low, alpha_high]
    float alpha_high = 1.0f;
    int depth_levels = 0;  // z takes this many values (few: many ties); 0: 2^20 values, no two equal at one
                           // pixel in practice for the sizes that tests use
    int draws = 1;
    enum class Order { kShuffled, kBackToFront, kFrontToBack } order = Order::kShuffled;
    bool partial_coverage = false;  // random non-empty sample masks, else all samples
    bool opaque = false;            // an opaque layer at random depths over half of the samples
    bool slopes = false;            // random depth slopes
    bool materials = false;         // random materials; halves with kFloat16
    ColorStorage color_storage = ColorStorage::kFloat32;  // kFloat16: colours are representable halves
};
TraceHeader random_header(const RandomFragments& options);
std::vector<Fragment> random_fragments(const RandomFragments& options);
// The same fragments with the channels that the options ask for.
FragmentChunk random_chunk(const RandomFragments& options);

// Coherent layers as a renderer makes them: each layer is a grid of shaded rectangles with smooth depth,
// colour and texture noise, rasterised triangle by triangle in 2x2 quads.
struct LayeredScene {
    std::uint64_t seed = 1;
    int width = 640;
    int height = 360;
    int layers = 8;              // mean depth complexity
    int cell = 48;               // pixels on a side of a layer's rectangles
    float alpha = 0.5f;          // mean
    int samples = 1;             // spatial ones; of more a pixel on an edge has a fragment of each triangle
    bool textured_alpha = true;  // 8-bit alpha texture, else constant in a layer
    ColorStorage color_storage = ColorStorage::kFloat16;
};
TraceHeader layered_header(const LayeredScene& options);
// Appends the scene's fragments to `writer` rectangle by rectangle: memory does not grow with the scene.
void append_layered(const LayeredScene& options, TraceWriter& writer);

// Writes a whole trace. Throws UserError.
void write_trace(const std::string& path, const TraceHeader& header, const std::vector<Fragment>& fragments);
// Reads all fragments of a trace that fits in memory. Throws UserError.
std::vector<Fragment> read_fragments(const std::string& path);

}  // namespace ropsim
