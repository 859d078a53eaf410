// The model's image against the software path's: the same frame, the same techniques, nothing shared but the
// fragments.
#pragma once

#include "analysis/validation_compare.h"
#include "capture/software_path/blending.h"
#include "capture/software_path/fragment_lists.h"
#include "traces/trace.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ropsim {

struct ValidationOptions {
    std::string input;  // a trace, or what `capture` takes: a scene or a file that becomes one
    std::vector<std::string>
        techniques;  // NAME[:key=value,...]; empty: all, as stored by their papers and exact
    std::optional<std::pair<int, int>> size;  // of a scene, with the next three
    int samples = 1;
    std::optional<std::uint64_t> fragments;
    std::uint64_t scene_seed = 1;
    std::uint64_t seed = 0;  // of the techniques' random draws
    Blending blending = Blending::kAutomatic;
    bool replay = false;  // draw a scene's captured fragments, not its geometry; a trace always
    int threads = 1;
    std::string directory;
};

// A pixel as both sides see it.
struct DifferingPixel {
    int x = 0, y = 0;
    std::array<float, 3> model{}, drawn{};
    std::vector<Fragment> model_fragments;  // visible, in arrival order
    std::vector<ListedFragment> drawn_fragments;
};
// Whether both lists hold the same bits: depth, colour, alpha, primitive, samples, in the same order.
bool same_fragments(const DifferingPixel& pixel);

struct ValidatedTechnique {
    std::string technique;
    std::string rendering;  // how the software path drew it
    std::string failure;    // why the model refuses the trace; empty: it was compared
    Agreement agreement;
    std::optional<DifferingPixel> first;
    std::string picture;  // file name of the difference picture
    double model_seconds = 0;
    double drawing_seconds = 0;
    bool differs() const { return failure.empty() && !agreement.holds(); }
    // Why values differ, in a few words; empty where none does.
    std::string cause() const;
};

struct Validation {
    ValidationOptions options;
    std::string scene;  // the trace's description
    std::string trace_hash;
    std::string drawn;  // "geometry" or "fragments"
    std::string renderer;
    DriverBlending driver;
    int width = 0, height = 0, samples = 1;
    std::uint64_t fragments = 0;
    std::uint64_t covered = 0;          // pixels with a visible fragment
    std::uint64_t other_fragments = 0;  // those where the trace's are not, bit for bit, what OpenGL draws
    std::vector<ValidatedTechnique> techniques;
    bool holds() const;  // none differs
};

// Writes the scene's trace (a scene's), a difference picture and EXR a technique, validation.md and
// validation.json into the directory. Throws UserError for a bad input, technique or driver. `progress` (may
// be empty) hears what is next.
Validation run_validation(const ValidationOptions& options,
                          const std::function<void(const std::string&)>& progress = {});

std::string validation_json(const Validation& validation);
std::string validation_table(const Validation& validation);
// A section of a page in Markdown.
std::string validation_markdown(const Validation& validation);

}  // namespace ropsim
