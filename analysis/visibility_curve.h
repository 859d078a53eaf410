// Visibility functions at one pixel, the exact one and what techniques make of it: Salvi et al. 2011, Fig. 8.
#pragma once

#include "analysis/pixel_run.h"

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace ropsim {

struct CurveOptions {
    std::string trace;                    // file
    std::string pixel = "deepest";        // X,Y or deepest
    std::vector<std::string> techniques;  // NAME[:key=value,...]; empty: those of default_techniques() that
                                          // represent visibility
    std::uint64_t seed = 0;
};

// The exact visibility: in each spatial sample the product of the transmittances of the fragments strictly in
// front, in double precision, and the mean over the samples.
class ExactVisibility {
 public:
    ExactVisibility(const PixelFragments& pixel, int samples);

    double operator()(double z) const;
    // Where it falls, ascending, without repetition.
    const std::vector<float>& depths() const { return depths_; }
    // Each fragment's depth in each sample that it covers.
    const std::vector<float>& fragment_depths() const { return fragment_depths_; }

 private:
    struct Step {
        float z = 0;
        double after = 1;
    };
    std::vector<std::vector<Step>> samples_;
    std::vector<float> depths_;
    std::vector<float> fragment_depths_;
};

// |representation - exact|. Over the shown range of depths: the largest, and the integral (trapezoids between
// the depths that are shown) and its mean. At the depths of the fragments, where composites ask: mean, root
// mean square and largest.
struct CurveError {
    double max = 0;
    double area = 0;  // visibility times window depth
    double mean = 0;  // area over the range's length
    double fragments_mean = 0, fragments_rms = 0, fragments_max = 0;
};

struct CurveOfTechnique {
    std::string technique;
    std::map<std::string, std::string> parameters;
    std::vector<float> visibility;  // at `depths`
    CurveError error;
};

struct VisibilityCurve {
    CurveOptions options;
    std::string trace_hash, scene;
    int width = 0, height = 0, samples = 1;
    PixelFragments pixel;
    std::vector<float> truth_depths;   // where the exact function falls
    std::vector<double> truth_behind;  // its value just behind each
    std::vector<float> depths;         // ascending: shown_depths()
    std::vector<double> truth;         // at `depths`
    std::vector<CurveOfTechnique> techniques;
};

// Depths at which functions are shown: kUniformDepths evenly over the fragments' range and a twentieth of it
// on both sides, up to `farthest` and inside [0, 1], and each of `steps` (ascending) with its neighbours
// among floats, so that steps are exact; of more than kMostSteps of them an even choice.
inline constexpr int kUniformDepths = 1025;
inline constexpr std::size_t kMostSteps = 5000;
std::vector<float> shown_depths(const std::vector<float>& steps, float farthest);

// `values` at `depths`, and `at_fragments` at the exact function's fragment_depths().
CurveError curve_error(const ExactVisibility& exact, std::span<const float> depths,
                       std::span<const float> values, std::span<const float> at_fragments);

// Throws UserError for a faulty trace or technique, one that represents no visibility, a pixel outside the
// image or without fragments (naming one that has some).
VisibilityCurve visibility_curve(const CurveOptions& options);

// One object with every number, "units" saying what each is in. Same inputs, same text.
std::string curve_json(const VisibilityCurve& curve);
// Aligned plain text: the errors, a line a technique.
std::string curve_table(const VisibilityCurve& curve);
// gnuplot's commands for both files: the exact function in grey, techniques over it, fragments as ticks.
std::string curve_plot_script(const VisibilityCurve& curve, const std::string& svg, const std::string& png);
// Writes DIRECTORY/curve.svg and curve.png, each atomically. Throws UserError when gnuplot is missing or
// fails.
void write_curve_plot(const VisibilityCurve& curve, const std::string& directory);

}  // namespace ropsim
