#include "analysis/stress/stress_hazards.h"

#include "analysis/stress/stress_inputs.h"
#include "analysis/stress/stress_tables.h"
#include "analysis/stress/stress_variants.h"
#include "rop/double_reading/double_pixel.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <fmt/format.h>

namespace ropsim {
namespace {

using Color = std::array<double, 3>;

Color mean_color(const std::string& technique, const TraceHeader& header, const PixelScene& scene, int seeds,
                 bool in_double) {
    Color sum{};
    for (int seed = 0; seed < seeds; ++seed) {
        const auto key = static_cast<std::uint64_t>(seed);
        const auto pixel = in_double ? ropsim_double::make_single_pixel(technique, header, key)
                                     : make_single_pixel(technique, header, key);
        const Color color = pixel->run(scene);
        for (std::size_t c = 0; c < 3; ++c) sum[c] += color[c] / seeds;
    }
    return sum;
}

}  // namespace

const std::vector<StressHazardCase>& stress_hazard_cases() {
    static const std::vector<StressHazardCase> list = [] {
        std::vector<StressHazardCase> all;
        for (const auto& part :
             {stored_product_hazards(), stored_sum_hazards(), arithmetic_hazards(), approximation_hazards()})
            all.insert(all.end(), part.begin(), part.end());
        return all;
    }();
    return list;
}

StressHazardOutcome run_hazard(const StressHazardCase& hazard) {
    const TraceHeader header = layer_input("even", 1, 0).header;
    StressHazardOutcome outcome;
    for (const PixelScene& scene : hazard.scenes) {
        const Color expected = hazard.reference.empty()
                                   ? exact_color(scene)
                                   : mean_color(hazard.reference, header, scene, hazard.seeds, true);
        const Color bad = mean_color(hazard.with, header, scene, hazard.seeds, false);
        const Color good = mean_color(hazard.cured, header, scene, hazard.seeds, false);
        for (std::size_t c = 0; c < 3; ++c) {
            outcome.lost += std::pow(bad[c] - expected[c], 2);
            outcome.left += std::pow(good[c] - expected[c], 2);
        }
    }
    const double values = 3 * static_cast<double>(hazard.scenes.size());
    outcome.lost = std::sqrt(outcome.lost / values);
    outcome.left = std::sqrt(outcome.left / values);
    const PixelTechnique with = make_single_pixel(hazard.with, header, 0)->technique();
    const PixelTechnique cured = make_single_pixel(hazard.cured, header, 0)->technique();
    outcome.bits = with.bits;
    outcome.node_bits = with.node_bits;
    outcome.more = cured.bits - with.bits;
    outcome.node_more = cured.node_bits - with.node_bits;
    outcome.more_passes = cured.passes - with.passes;
    return outcome;
}

std::string stress_hazards_markdown() {
    std::string text =
        "\n## Hazards and cures\n\nErrors in units of 1/255, root mean square of a channel over the hazard's "
        "pixels. Bits are a pixel's and, of lists, a stored fragment's node; passes are over the "
        "geometry.\n\n";
    add_heading(text, {"hazard", "with", "lost", "cured by", "left", "bits", "bits more", "passes more"});
    for (const StressHazardCase& hazard : stress_hazard_cases()) {
        const StressHazardOutcome outcome = run_hazard(hazard);
        add_row(text,
                {hazard.what, fmt::format("`{}`", hazard.with), in_255(outcome.lost),
                 fmt::format("`{}`", hazard.cured), in_255(outcome.left),
                 bits_text(outcome.bits, outcome.node_bits), more_bits_text(outcome.more, outcome.node_more),
                 fmt::format("{:+}", outcome.more_passes)});
    }
    return text;
}

}  // namespace ropsim
