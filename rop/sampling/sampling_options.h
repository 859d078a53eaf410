// What the user chooses about a technique of stored samples beyond how it picks them: which passes, which
// correction, how many rounds, which filter.
#pragma once

#include "base/parameters.h"
#include "rop/operation.h"

#include <cstdint>

namespace ropsim {

enum class SampleMethod : std::uint8_t {
    kBasic,       // samples keep depth and colour (ST 3.1)
    kDepthBased,  // samples keep depth, a further pass accumulates colour (ST 3.4)
};
enum class Correction : std::uint8_t {
    kNone,
    kCoverage,     // total alpha over the share of samples that hold a fragment, F(B1) (ST 4.1)
    kAccumulated,  // total alpha over the accumulated alpha, F(U1) (ST 4.2)
};

// ST: Enderton et al. 2011.
struct SamplingOptions {
    int samples = 8;           // S of a pixel, over all rounds
    int hardware_samples = 8;  // stored at a time
    int spatial_samples = 1;   // M of the trace
    SampleMethod method = SampleMethod::kBasic;
    Correction correction = Correction::kNone;
    bool total_per_sample = false;        // total alpha a sample, else a pixel (ST 3.5)
    bool accumulator_per_sample = false;  // accumulated colour a sample, else a pixel
    bool merged = false;                  // total alpha in the same pass as colour
    bool strata_across_rounds = true;     // ST, notes 3 and 4
    DisplayFilter filter = DisplayFilter::kBox;
    bool early_termination = false;
    double adaptive_error = 0;  // standard error at which a pixel takes no further round, of 255; 0: off
    int adaptive_rounds = 4;    // before a pixel may stop: two may agree by accident
    int cross_filter = 0;       // radius in pixels; 0: off
    double cross_sigma = 0.05;  // of total alpha

    // Reads the keys of `parameters` that both techniques share. Throws UserError for
    // combinations that make no sense.
    SamplingOptions(Parameters& parameters, const Screen& screen);
    // Of a technique that keeps depths alone: one round of the basic method. Reads `samples` and nothing
    // else.
    static SamplingOptions depth_alone(Parameters& parameters, const Screen& screen);

    int rounds() const { return samples / hardware_samples; }
    bool has_total() const { return correction != Correction::kNone; }
    bool depth_based() const { return method == SampleMethod::kDepthBased; }
    bool adaptive() const { return adaptive_error > 0; }
    // Whether something must be kept of a round before its surfaces are used again: an image pass.
    bool gathers() const {
        return rounds() > 1 && (!depth_based() || correction != Correction::kAccumulated || adaptive());
    }
    // Whether samples start as the opaque layer and resolve is their mean.
    bool over_opaque() const { return !depth_based() && correction == Correction::kNone; }

    static constexpr int kMaxSamples = 64;

 private:
    explicit SamplingOptions(int spatial) : spatial_samples(spatial) {}
    void read_samples(Parameters& parameters);
    void read_rounds(Parameters& parameters);
    void read_correction(Parameters& parameters);
    void check(const Parameters& parameters) const;
};

}  // namespace ropsim
