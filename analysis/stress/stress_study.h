// How stable techniques are: every technique in every stored format on every input, against the same
// operation in double precision (rounding) and against exact compositing (rounding and the algorithm's own
// approximation).
#pragma once

#include "analysis/stress/stress_inputs.h"
#include "analysis/stress/stress_page.h"
#include "analysis/stress/stress_variants.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

// Why a value that is none, or light that is too bright, may come out: known of a variant and an input before
// anything is run.
enum class StressHazard : std::uint8_t {
    kNone,    // it may not
    kFormat,  // a surface's format cannot hold what is declared for it
    kLight,   // the technique's own formula adds light: see LightLaw
};
inline constexpr std::array<std::string_view, 3> kStressHazardNames{"", "format", "light"};

struct StressFaults {
    std::uint64_t not_numbers = 0;
    std::uint64_t infinite = 0;  // and the largest binary16, for which the resolve takes infinity
    std::uint64_t negative = 0;
    std::uint64_t too_bright = 0;  // see most_light()

    std::uint64_t all() const { return not_numbers + infinite + negative + too_bright; }
    StressFaults& operator+=(const StressFaults& other) {
        not_numbers += other.not_numbers;
        infinite += other.infinite;
        negative += other.negative;
        too_bright += other.too_bright;
        return *this;
    }
};

// A variant on an input. Errors are the largest difference of a channel, relative to the pixel's brightest
// colour (at least 1); -1 stands for not measured: the technique has no such thing, or the input none.
struct StressResult {
    std::size_t technique = 0;
    std::size_t variant = 0;
    std::size_t input = 0;
    bool left_out = false;       // a list of this depth would take too long
    double worst_error = -1;     // against exact compositing
    double mean_error = -1;      // over channels
    double worst_rounding = -1;  // against the double-precision run
    double mean_rounding = -1;
    double worst_algorithm = -1;    // of the double-precision run against exact compositing
    std::uint64_t other_paths = 0;  // pixels on which the double-precision run took other control paths
    std::uint64_t values = 0;       // channels looked at
    StressHazard hazard = StressHazard::kNone;
    StressFaults faults;
    double rise = -1;  // the largest of visibility with depth, and of the double-precision run
    double rise_exact = -1;
    double outside = -1;         // how far visibility leaves [0, 1]
    double order_change = -1;    // largest change of a channel when fragments arrive in another order
    double white_loss = -1;      // white fragments before white: the difference to white, and the part of
    double white_rounding = -1;  // it that the double-precision run does not have
};

struct StressStudy {
    std::vector<StressTechnique> techniques;
    std::vector<StressInput> inputs;
    std::vector<StressResult> results;  // technique by technique, variant by variant, input by input
    std::uint64_t seed = 0;
    double seconds = 0;

    std::size_t measured() const;
    // Of combinations without a hazard: none may have any.
    std::size_t held() const;
    StressFaults faults() const;
};

StressStudy run_stress_study(std::vector<StressTechnique> techniques, std::vector<StressInput> inputs,
                             std::uint64_t seed, int threads);

// Of one technique on one input, for tests.
std::vector<StressResult> stress_results(const StressTechnique& technique, const StressInput& input,
                                         std::uint64_t seed);

// Every number of every combination; what they come to by technique and format; the same for readers.
std::string stress_csv(const StressStudy& study);
std::string stress_json(const StressStudy& study);
std::string stress_markdown(const StressStudy& study);
// Tables for a page: see stress_page.h.
std::vector<StressBlock> stress_blocks(const StressStudy& study);

}  // namespace ropsim
