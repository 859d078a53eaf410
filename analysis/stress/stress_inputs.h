// What the stability study runs techniques on: pixels of the stress traces and of captured scenes, and series
// of layers from 1 to 100,000.
#pragma once

#include "rop/single_pixel.h"
#include "traces/trace.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

struct StressInput {
    std::string name;        // "trace coplanar", "scene hair", "layers thin 1000"
    std::string kind;        // "traces", "scenes" or the class of the layers: "thin", "even", "bright"
    std::size_t layers = 0;  // of a series
    TraceHeader header;
    bool physical = true;  // every value finite and within its range
    std::vector<PixelScene> pixels;

    std::size_t most_fragments() const;
};

// Of a pixel, in double precision: front to back, of equal depths the earlier arrival nearer.
std::array<double, 3> exact_color(const PixelScene& pixel);

// Covered pixels of a trace: the deepest ones, and others spread evenly over the rest.
StressInput trace_input(const std::string& name, const std::string& kind, const std::string& path,
                        std::size_t most_pixels);
// `layers` fragments at a pixel, random depths and colours: thin: alpha 1/layers; even: .01 each; bright:
// random alpha and colours up to 64.
StressInput layer_input(const std::string& kind, std::size_t layers, std::uint64_t seed);

struct StressInputOptions {
    std::vector<std::string> scenes;  // captured at about 100,000 fragments each
    std::vector<std::size_t> layers{1, 10, 100, 1000, 10000, 100000};
    std::size_t trace_pixels = 24;
    std::size_t scene_pixels = 256;
    std::uint64_t seed = 0;
};
inline constexpr std::uint64_t kStressSceneFragments = 100'000;
// Captures the scenes in child processes. Throws UserError.
std::vector<StressInput> stress_inputs(const StressInputOptions& options);

}  // namespace ropsim
