#include "analysis/shadow_filter_choice.h"

#include "base/error.h"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace ropsim {

namespace {

constexpr const char* kOption = "--filter";

void check_odd(std::int64_t texels) {
    if (texels % 2 == 0)
        throw UserError(kOption,
                        fmt::format("{} texels have none in their middle; use an odd number", texels));
}

VarianceOptions variance_options(Parameters& parameters) {
    VarianceOptions options;
    options.tent = static_cast<int>(parameters.get_integer("tent", 15, 1, VarianceOptions::kMaxTent));
    check_odd(options.tent);
    options.downsample =
        static_cast<int>(parameters.get_integer("downsample", 4, 1, VarianceOptions::kMaxDownsample));
    if (parameters.get_choice("reduction", "kept", {"kept", "mean"}) == "mean")
        options.reduction = Reduction::kMean;
    const std::string passes = parameters.get_choice("passes", "reduced", {"separate", "reduced", "fused"});
    options.passes = passes == "separate" ? ConversionPasses::kSeparate
                     : passes == "fused"  ? ConversionPasses::kFused
                                          : ConversionPasses::kReduced;
    options.bilinear = parameters.get_choice("fetch", "bilinear", {"bilinear", "nearest"}) == "bilinear";
    options.min_variance = parameters.get_real("min_variance", options.min_variance, 0.0, 1.0);
    options.light_bleeding = parameters.get_real("light_bleeding", 0.0, 0.0, 0.99);
    return options;
}

}  // namespace

FilterChoice parse_filter(const std::string& text) {
    const std::size_t colon = text.find(':');
    FilterChoice choice;
    choice.name = text.substr(0, colon);
    choice.parameters = Parameters::from_list(
        "--filter " + choice.name,
        colon == std::string::npos ? std::string_view() : std::string_view(text).substr(colon + 1), kOption);
    if (choice.name == "variance") {
        choice.variance = true;
        choice.conversion = variance_options(choice.parameters);
    } else if (choice.name == "tent" || choice.name == "disc") {
        choice.closer.shape = choice.name == "tent" ? FilterShape::kTent : FilterShape::kDisc;
        const std::int64_t side = choice.parameters.get_integer("side", 15, 1, ShadowFilter::kMaxSide);
        check_odd(side);
        choice.closer.side = static_cast<int>(side);
    } else {
        int side = 0;
        const char* const end = choice.name.data() + choice.name.size();
        const auto [stopped, failure] = std::from_chars(choice.name.data(), end, side);
        if (failure != std::errc() || stopped != end || side < 1 || side > ShadowFilter::kMaxSide)
            throw UserError(kOption, fmt::format("'{}' is neither a side of 1 to {} texels nor tent, disc or "
                                                 "variance",
                                                 choice.name, ShadowFilter::kMaxSide));
        check_odd(side);
        choice.closer.side = side;
        choice.name = "square";
    }
    choice.parameters.close();
    return choice;
}

}  // namespace ropsim
