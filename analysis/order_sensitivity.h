// How far a technique's image depends on the order in which fragments arrive: the same fragments in several
// random orders, as captured, and sorted both ways.
#pragma once

#include "analysis/image_spread.h"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace ropsim {

struct OrderSensitivityOptions {
    std::string trace;                    // file
    std::vector<std::string> techniques;  // NAME[:key=value,...]; empty: techniques_at_defaults()
    std::string hardware = "desktop";
    std::vector<std::string> settings;  // key=value
    int orders = 8;                     // random ones, 2 or more
    std::uint64_t order_seed = 1;       // order i, from 0, is shuffled with order_seed + i
    std::uint64_t seed = 0;             // of the techniques' randomness
    int threads = 1;
    std::string directory;  // exists; holds one reordered trace at a time
};

// Orders besides the random ones.
enum class NamedOrder : std::uint8_t { kCaptured, kNearToFar, kFarToNear };
inline constexpr std::array<const char*, 3> kNamedOrders{"captured", "near_to_far", "far_to_near"};

struct OrderSensitivityOfTechnique {
    std::string technique;  // as given
    std::string failure;    // why there are no results; empty: there are
    std::map<std::string, std::string> parameters;
    bool any_order = false;  // the technique declares that any order gives the same image, up to ties and
                             // rounding
    bool random = false;     // the image depends on the seed, which is the same in all orders
    SpreadFigures spread;    // over the random orders, pixels with a transparent fragment
    std::array<double, 3> named_rmse8_covered{};  // by NamedOrder, against the reference, the same pixels
    std::vector<double> random_rmse8_covered;     // by order
};

struct OrderSensitivity {
    OrderSensitivityOptions options;
    std::string trace_hash;
    std::string scene;  // what was captured; may be empty
    int width = 0, height = 0, samples = 1;
    std::uint64_t fragments = 0;
    std::uint64_t covered_pixels = 0;
    std::vector<OrderSensitivityOfTechnique> techniques;
};

// Refuses a technique that is given twice, unknown, misspelt, makes no colour image or refuses the trace; a
// trace that cannot be read. Throws UserError.
void check_order_sensitivity(const OrderSensitivityOptions& options);

// Runs every technique on every order with fidelity `count`. Reordered traces are those of `trace order`:
// draws and primitives stay with their fragments, so that random draws do too, and fragments of one pixel and
// depth keep their order, so that the reference stays. Progress on stderr. Throws UserError as the check, and
// for a faulty trace or a directory that cannot be written. Memory: 76 bytes for each technique and pixel
// with a fragment, besides one run and one reordering.
OrderSensitivity run_order_sensitivity(const OrderSensitivityOptions& options);

// One object with every number, "units" saying what each is in. Same inputs, same text.
std::string order_sensitivity_json(const OrderSensitivity& study);
// One line a technique under a heading; what was not measured is empty.
std::string order_sensitivity_csv(const OrderSensitivity& study);
// Aligned plain text: two heading lines, then a line a technique.
std::string order_sensitivity_table(const OrderSensitivity& study);

}  // namespace ropsim
