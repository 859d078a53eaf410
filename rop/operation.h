// A framebuffer operation as the rest of the program sees it: batches of fragments in, pixel state and a log
// out.
#pragma once

#include "base/parameters.h"
#include "rop/cost.h"
#include "rop/declaration.h"
#include "rop/operation_log.h"
#include "rop/pixel_store.h"
#include "rop/window.h"
#include "traces/trace.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

// What an operation is built for: the image's size, the trace's spatial samples and camera, the run's seed.
struct Screen {
    int width = 1;
    int height = 1;
    int samples = 1;  // M
    std::uint64_t seed = 0;
    std::vector<std::uint32_t> objects = {};  // object of each draw of the trace; empty: draws are objects
    std::optional<Camera> camera = {};        // of the trace's view
    std::vector<std::string> draws = {};      // names of the trace's draws
    bool materials = false;                   // the trace says what its surfaces do to light
};

// Of a trace's header.
inline Screen screen_of(const TraceHeader& header, std::uint64_t seed) {
    Screen screen{header.width, header.height, header.samples, seed};
    for (const Draw& draw : header.draws) {
        screen.objects.push_back(draw.object_id);
        screen.draws.push_back(draw.name);
    }
    screen.camera = header.camera;
    screen.materials = header.materials;
    return screen;
}

// Fragments with the slopes of their depth planes and their materials, each empty where the trace has none
// (or nobody asks).
struct FragmentSpan {
    std::span<const Fragment> fragments;
    std::span<const DepthSlope> slopes = {};
    std::span<const Material> materials = {};
};

// One charged operation on real values: for the tests that hold it against the cost table and the plain
// datapath.
struct ChargedOutcome {
    int path = 0;
    Work work;
    std::array<std::uint32_t, 2> steps{};
    std::array<Work, 2> step_work{};  // of one step; empty where none was taken
    PixelAccess access{};
};

class FramebufferOperation {
 public:
    virtual ~FramebufferOperation() = default;
    virtual const Declaration& declaration() const = 0;

    // Operates on fragment `index` for each index, in that order, all of one partition. Fragments must have
    // passed the depth test. `round`: of a repeated pass. Thread-safe as long as stores and logs are not
    // shared.
    virtual void run(int pass, int round, const FragmentSpan& fragments,
                     std::span<const std::uint32_t> indices, PixelStore& store, OperationLog& log) const = 0;
    // Runs an image pass over a touched tile's pixels inside the image (of the pass's resolution), row by
    // row. Where it gathers, `stores` says where other pixels are; what it reads of them must not change.
    virtual void image_pass(int pass, int round, PixelStore& store, const StoreMap& stores, int tile_x,
                            int tile_y, OperationLog& log) const = 0;
    // Writes the final colours of a tile's pixels inside the image, row by row, 3 floats each, to `rgb`
    // (kTilePixels * 3). Where the declaration has a footprint or gathers, `stores` says where the pixels
    // around are; they must not change meanwhile.
    virtual void resolve(PixelStore& store, const StoreMap& stores, int tile_x, int tile_y, float* rgb,
                         OperationLog& log) const = 0;

    // Every control path with its units, latency, interval and worst-case bytes, measured on the charged
    // datapath.
    virtual CostTable cost(const DatapathShape& shape) const = 0;
    virtual ChargedOutcome charged_fragment(const DatapathShape& shape, int pass, int round,
                                            const Fragment& fragment, const FragmentChannels& channels,
                                            PixelStore& store) const = 0;
    virtual ChargedOutcome charged_image_pass(const DatapathShape& shape, int pass, int round,
                                              PixelStore& store, const StoreMap& stores, int x,
                                              int y) const = 0;
    virtual ChargedOutcome charged_resolve(const DatapathShape& shape, PixelStore& store,
                                           const StoreMap& stores, int x, int y, float* rgb) const = 0;
    // Whether the technique represents visibility, and the transmittance in front of each of `depths` at a
    // pixel whose passes have run (in `values`, of the same length).
    virtual bool has_visibility() const = 0;
    virtual void visibility(PixelStore& store, int x, int y, std::span<const float> depths,
                            std::span<float> values) const = 0;
    // The technique's own word of each pixel, for the PixelStore; null when it has none.
    virtual PixelConstant pixel_constant() const = 0;
};

struct TechniqueInfo {
    std::string_view name;
    std::string_view summary;  // with paper and year
    std::string_view keys;     // its parameters, for `ropsim list techniques`
    bool headline = false;     // run by the demo and by `compare` without --technique
    std::string_view headline_parameters = "";
};

}  // namespace ropsim
