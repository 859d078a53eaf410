// The surfaces of a technique of stored samples, and the paths its passes take.
#pragma once

#include "rop/declaration.h"
#include "rop/sampling/sampling_options.h"
#include "rop/technique_formats.h"

#include <string>
#include <vector>

namespace ropsim {

// Handles of what a pixel keeps. Which of them exist depends on the options.
struct SampleSurfaces {
    Field depth;        // a hardware sample: of the nearest fragment that took it
    Field color;        // basic: its colour; a fourth channel says that there is one
    Field accumulated;  // depth-based: sum of visibility x alpha x colour
    Field total;        // product of transmittances
    Field weight;       // depth-based: sum of visibility x alpha
    Field farthest;     // early termination: the largest of the stored depths
    Field sum;          // several rounds: the rounds' colours, or the shares of samples taken
    Field sum_coverage;
    Field rounds;               // adaptive: rounds drawn, and kSettled
    Field statistics;           // adaptive: sums of colour and weight before this round, of x and of x^2
    std::vector<int> restored;  // surfaces that every round starts anew
};

// What a pass does.
enum class SamplePass : std::uint8_t { kTotalAlpha, kWrite, kAccumulate, kGather, kCorrect };

// Numbers of the control paths; -1 for those the options exclude.
struct SamplePaths {
    int nothing = -1, write = -1, settled_write = -1, saturated_write = -1;
    int total_alpha = -1;
    int accumulate = -1, unseen = -1, settled_accumulate = -1, saturated_accumulate = -1;
    int gather = -1, go_on = -1, settle = -1, settled = -1;
    int correct = -1;
    int resolve = -1;
};

inline constexpr std::uint32_t kSettled = 0x80;  // in SampleSurfaces::rounds, above the count

// Declares depth, colour or accumulation, and total alpha. The chooser's own surfaces come next.
void declare_samples(const SamplingOptions& options, const TechniqueFormats& formats,
                     Declaration& declaration, SampleSurfaces& surfaces);
// Then what several rounds and early termination keep.
void declare_rounds(const SamplingOptions& options, const TechniqueFormats& formats, Declaration& declaration,
                    SampleSurfaces& surfaces);
// And the passes with their paths; `nothing` and `write` name the first two.
std::vector<SamplePass> declare_passes(const SamplingOptions& options, const std::string& nothing,
                                       const std::string& write, Declaration& declaration,
                                       const SampleSurfaces& surfaces, SamplePaths& paths);

}  // namespace ropsim
