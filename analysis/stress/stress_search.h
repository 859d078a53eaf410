// The worst pixel of a technique: found by random pixels and by evolution from the worst of them, among
// physical inputs: alpha and depth in [0, 1], colours in [0, 1] or up to 64. The paper's formats are
// held to colours in [0, 1]: many end there, which is their range and no rounding.
#pragma once

#include "rop/single_pixel.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

// What is to be large, of a channel and relative to the pixel's brightest colour (at least 1).
enum class StressGoal : std::uint8_t {
    kRounding,       // in the paper's formats against the operation in double precision
    kArithmetic,     // the same with every value in float32
    kApproximation,  // the operation in double precision against exact compositing
};
inline constexpr std::array<std::string_view, 3> kStressGoalNames{"rounding", "arithmetic", "approximation"};

// One technique in the three readings. `technique` is at its paper's formats.
class StressedPixel {
 public:
    StressedPixel(const std::string& technique, std::uint64_t seed);
    // Infinity where something that is compared is no number.
    double error(const PixelScene& pixel, StressGoal goal);
    // Of every goal.
    std::array<double, 3> errors(const PixelScene& pixel);
    // Whether the colours in the paper's formats and in float32 are finite and not negative.
    bool is_color(const PixelScene& pixel);

 private:
    TraceHeader header_;
    std::unique_ptr<SinglePixel> paper_, single_, double_;
};

struct WorstPixel {
    std::string technique;
    StressGoal goal = StressGoal::kRounding;
    double error = 0;
    PixelScene pixel;
    std::uint64_t evaluations = 0;  // of the search
    // Found afterwards by random pixels alone.
    std::uint64_t random_pixels = 0;
    std::uint64_t random_fragments = 0;
    double random_error = 0;
};

struct StressSearch {
    std::vector<std::string> techniques;
    std::uint64_t evaluations = 20'000;  // for each technique and goal
    std::uint64_t random_fragments = 0;  // afterwards, for each technique
    std::uint64_t seed = 0;
    int threads = 1;
};

// Every technique and goal. The same for any number of threads.
std::vector<WorstPixel> search_worst_pixels(const StressSearch& search);

std::string worst_pixels_json(const std::vector<WorstPixel>& pixels);
// Throws UserError, naming `where`.
std::vector<WorstPixel> read_worst_pixels(const std::string& json, const std::string& where);
std::string worst_pixels_markdown(const std::vector<WorstPixel>& pixels);

}  // namespace ropsim
