#include "analysis/validation_compare.h"

#include "base/error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace ropsim {
namespace {

constexpr double kRelative = 1e-6;
// Below it a float32 value is judged absolutely: what is left of a light after twenty halvings.
constexpr double kLeastValue = 1e-6;

// Binary16 values in order, one apart; of a value that a half can hold.
double half_number(float value) {
    const double magnitude = std::abs(static_cast<double>(value));
    if (magnitude < 0x1p-14) return std::copysign(magnitude * 0x1p24, static_cast<double>(value));
    int exponent = 0;
    const double mantissa = std::frexp(magnitude, &exponent);  // in [1/2, 1)
    const double number = 1024.0 * (exponent + 13) + (2 * mantissa - 1) * 1024.0 + 1024.0;
    return std::copysign(number, static_cast<double>(value));
}

std::size_t base_of(const Image& image, std::size_t pixel) {
    return pixel * image.channels.size();
}

void check_images(const Image& model, const Image& drawn) {
    CHECK(model.width == drawn.width && model.height == drawn.height, "{}x{} and {}x{}", model.width,
          model.height, drawn.width, drawn.height);
    CHECK(model.channel("R") == 0 && drawn.channel("R") == 0, "channels");
}

}  // namespace

std::string AgreementBound::text() const {
    std::string text =
        unit_limit < 1e-3 ? fmt::format("{:g} relative", unit_limit) : fmt::format("{:g}", unit_limit);
    if (absolute > 0) text += fmt::format(" or {:g}", absolute);
    text += within_share < 1 ? fmt::format(" on {:g} %", 100 * within_share) : " on all";
    if (equal_share > 0) text += fmt::format(", equal on {:g} %", 100 * equal_share);
    return text;
}

AgreementBound agreement_bound(Format stored, double function_bound) {
    switch (stored) {
        case Format::kFloat16:
            // A rounding left out in between is 1 unit at most, but nearly everywhere.
            return {1, 0.9999, function_bound > 0 ? 0 : 0.95, function_bound};
        case Format::kUnorm8:
            return {1, 1, 0.999, function_bound};
        default:
            return {kRelative, 1, 0, function_bound};
    }
}

const char* unit_name(Format stored) {
    return stored == Format::kFloat16 ? "ulp" : stored == Format::kUnorm8 ? "codes" : "relative";
}

double units_apart(Format stored, float a, float b) {
    if (std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || a == b) return 0;
    if (!std::isfinite(a) || !std::isfinite(b)) return std::numeric_limits<double>::infinity();
    if (stored == Format::kFloat16) return std::abs(half_number(a) - half_number(b));
    const double difference = std::abs(static_cast<double>(a) - static_cast<double>(b));
    if (stored == Format::kUnorm8) return difference * 255;
    return difference /
           std::max({static_cast<double>(std::abs(a)), static_cast<double>(std::abs(b)), kLeastValue});
}

Agreement compare_images(const Image& model, const Image& drawn, const std::vector<PixelKind>& kinds,
                         Format stored, double function_bound) {
    check_images(model, drawn);
    Agreement result;
    result.stored = stored;
    result.bound = agreement_bound(stored, function_bound);
    // Codes are whole numbers but for the float that holds them.
    const double limit = result.bound.unit_limit * (stored == Format::kUnorm8 ? 1.001 : 1.0);
    int first_rank = 0;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        if (kinds[i] == PixelKind::kLeftOut) continue;
        ++result.pixels;
        PixelDifference difference{static_cast<int>(i % static_cast<std::size_t>(model.width)),
                                   static_cast<int>(i / static_cast<std::size_t>(model.width)), 0,
                                   kinds[i] == PixelKind::kOtherFragments};
        bool within = true;
        for (std::size_t c = 0; c < 3; ++c) {
            const float a = model.values[base_of(model, i) + c];
            const float b = drawn.values[base_of(drawn, i) + c];
            const double units = units_apart(stored, a, b);
            const double absolute =
                units == 0 ? 0 : std::abs(static_cast<double>(a) - static_cast<double>(b));
            within = within && (units <= limit || absolute <= result.bound.absolute);
            difference.units = std::max(difference.units, units);
            result.worst_absolute = std::max(result.worst_absolute, absolute);
        }
        const bool equal = difference.units == 0;
        result.worst_units = std::max(result.worst_units, difference.units);
        result.equal += equal;
        result.within += within;
        result.unequal_excused += !equal && difference.other_fragments;
        result.outside_excused += !within && difference.other_fragments;
        if (equal) continue;
        if (!within && result.exceptions.size() < Agreement::kMostExceptions)
            result.exceptions.push_back(difference);
        const int rank = (within ? 1 : 3) + (difference.other_fragments ? 0 : 1);
        if (rank > first_rank) {
            result.first = difference;
            first_rank = rank;
        }
    }
    return result;
}

Image difference_picture(const Image& model, const Image& drawn, const std::vector<PixelKind>& kinds,
                         Format stored) {
    check_images(model, drawn);
    Image picture(model.width, model.height, {"R", "G", "B"});
    const double unit = stored == Format::kFloat32 ? kRelative : 1;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        if (kinds[i] == PixelKind::kLeftOut) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            const double units = units_apart(stored, model.values[base_of(model, i) + c],
                                             drawn.values[base_of(drawn, i) + c]) /
                                 unit;
            picture.values[3 * i + c] = static_cast<float>(std::min(units, 16.0) / 16.0);
        }
    }
    return picture;
}

Image difference_channels(const Image& model, const Image& drawn, const std::vector<PixelKind>& kinds,
                          Format stored) {
    check_images(model, drawn);
    Image image(model.width, model.height,
                {"R", "G", "B", "model.R", "model.G", "model.B", "units.R", "units.G", "units.B"});
    for (std::size_t i = 0; i < kinds.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            const float a = model.values[base_of(model, i) + c];
            const float b = drawn.values[base_of(drawn, i) + c];
            image.values[9 * i + c] = b;
            image.values[9 * i + 3 + c] = a;
            if (kinds[i] != PixelKind::kLeftOut)
                image.values[9 * i + 6 + c] = static_cast<float>(units_apart(stored, a, b));
        }
    return image;
}

}  // namespace ropsim
