// What formats can hold and how far they round is what they do; techniques declare it of their surfaces; and
// the stability study tells by it, before anything runs, where values that are no colour may come out.
#include "analysis/standard_techniques.h"
#include "analysis/stress/stress_inputs.h"
#include "analysis/stress/stress_page.h"
#include "analysis/stress/stress_study.h"
#include "analysis/stress/stress_variants.h"
#include "base/error.h"
#include "rop/registry.h"
#include "rop/value_range.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

const std::vector<Format>& real_formats() {
    static const std::vector<Format> list{Format::kFloat32,   Format::kFloat16, Format::kUnorm8,
                                          Format::kUnorm16,   Format::kUnorm24, Format::kSnorm8,
                                          Format::kR11G11B10, Format::kRgb9e5,  Format::kLog8};
    return list;
}
// Rounded, but not cut off.
bool keeps(Format format, float value) {
    const float stored = stored_rgb(format, {value, value, value})[2];
    return std::abs(stored - value) <= 0.02f * std::max(1.0f, std::abs(value));
}

TEST(ValueRange, FormatsHoldWhatTheyKeep) {
    struct Case {
        ValueRange range;
        bool bright;
        std::vector<float> values;
    };
    const std::vector<Case> cases{
        {ValueRange::kUnit, true, {0, 0.3f, 1}},   {ValueRange::kSignedUnit, true, {-1, -0.3f, 1}},
        {ValueRange::kColor, false, {0, 0.5f, 1}}, {ValueRange::kColor, true, {0, 1.5f, 64}},
        {ValueRange::kSum, false, {0, 3, 1000}},   {ValueRange::kSignedSum, false, {-1000, -2, 3}}};
    for (const Format format : real_formats())
        for (const Case& c : cases)
            EXPECT_EQ(holds(format, c.range, c.bright),
                      std::ranges::all_of(c.values, [&](float v) { return keeps(format, v); }))
                << format_info(format).name << " range " << static_cast<int>(c.range) << " bright "
                << c.bright;
}

// Packed into so many bits, a sum ends; what is counted does not.
TEST(ValueRange, PackedSumsEnd) {
    EXPECT_TRUE(holds(Format::kBits, ValueRange::kUnit, true));
    EXPECT_FALSE(holds(Format::kBits, ValueRange::kSum, false));
    EXPECT_FALSE(holds(Format::kBits, ValueRange::kSignedSum, false));
    const auto narrow = [](const std::string& technique) {
        return stress_techniques({technique}, false).front().variants.front().narrow;
    };
    const std::vector<NarrowField> packed = narrow("hybrid");
    ASSERT_EQ(packed.size(), 2u);
    for (const NarrowField& field : packed) {
        EXPECT_EQ(field.surface, "tail");
        EXPECT_EQ(field.range, ValueRange::kSum);
    }
    EXPECT_EQ(narrow("hybrid:tail_format=float16").size(), 0u);
    // A count and a bitmap are no such thing.
    EXPECT_EQ(narrow("hybrid:format=float32").size(), 0u);
    EXPECT_EQ(narrow("occupancy_map").size(), 0u);
}

// Displacements add up with their signs, blurs without; where there is no material neither is ever more than
// 0.
TEST(ValueRange, DisplacementAndBlurAreSums) {
    struct Found {
        std::vector<ValueRange> delta, beta;
    };
    const auto ranges = [](const std::string& technique, bool materials) {
        Screen screen = screen_with_camera();
        screen.materials = materials;
        TechniqueSpec spec = parse_technique(technique, "--technique");
        const auto operation = make_operation(spec, screen);
        Found found;
        for (const Surface& s : operation->declaration().surfaces)
            for (const StoredField& field : s.fields) {
                if (s.name == "delta") found.delta.push_back(field.range);
                if (s.name == "beta") found.beta.push_back(field.range);
            }
        return found;
    };
    using enum ValueRange;
    const std::vector<ValueRange> unit{kUnit}, sums{kSum}, transmitted{kUnit, kSum};
    EXPECT_EQ(ranges("phenomenological", true).delta, std::vector{kSignedSum});
    EXPECT_EQ(ranges("phenomenological", true).beta, transmitted);
    EXPECT_EQ(ranges("phenomenological:offsets=split", true).delta, sums);
    EXPECT_EQ(ranges("phenomenological:offsets=biased", true).delta, sums);
    EXPECT_EQ(ranges("phenomenological:separate_alpha=off", true).delta,
              (std::vector{kSignedSum, kSum, kUnit}));
    EXPECT_EQ(ranges("phenomenological:refraction=off,diffusion=off", true).delta, unit);
    EXPECT_EQ(ranges("phenomenological", false).delta, unit);
    EXPECT_EQ(ranges("phenomenological", false).beta, (std::vector{kUnit, kUnit}));
}

TEST(ValueRange, NoFormatRoundsByMoreThanItsHalfStep) {
    for (const Format format : real_formats()) {
        double most = 0;
        for (int i = 0; i <= 100'000; ++i) {
            const float value = static_cast<float>(i) / 100'000;
            const float stored = stored_rgb(format, {value, value, value})[2];
            most = std::max(most, std::abs(static_cast<double>(stored) - static_cast<double>(value)));
        }
        EXPECT_LE(most, half_step(format) * 1.001 + 0x1p-24) << format_info(format).name;
        if (format != Format::kFloat32) {
            EXPECT_GE(most, half_step(format) / 5) << format_info(format).name;
        }
    }
}

const StressVariant& variant(const StressTechnique& technique, const std::string& formats) {
    const auto found = std::ranges::find(technique.variants, formats, &StressVariant::formats);
    EXPECT_NE(found, technique.variants.end()) << formats;
    return *found;
}

TEST(StressHazards, AreKnownFromDeclarations) {
    const std::vector<StressTechnique> t =
        stress_techniques({"weighted_blended", "fourier_map:coefficients=7", "k_buffer:layers=8",
                           "moment_based:moments=4", "fourier_map:coefficients=7,clamp=off"},
                          true);
    EXPECT_EQ(variant(t[0], "paper").narrow.size(), 0u);
    EXPECT_EQ(variant(t[0], "revealage unorm8").narrow.size(), 0u);
    ASSERT_EQ(variant(t[0], "color unorm16").narrow.size(), 1u);
    EXPECT_EQ(variant(t[0], "color unorm16").narrow[0].surface, "accumulated_color");
    EXPECT_EQ(variant(t[0], "color unorm16").narrow[0].range, ValueRange::kSum);
    EXPECT_EQ(variant(t[1], "coefficients float16").narrow.size(), 0u);
    EXPECT_EQ(variant(t[1], "coefficients snorm8").narrow.size(), 1u);
    EXPECT_EQ(variant(t[2], "paper").narrow.size(), 0u);
    EXPECT_EQ(variant(t[2], "paper").narrow_if_bright.size(), 1u);
    EXPECT_EQ(variant(t[2], "color float16").narrow_if_bright.size(), 0u);
    EXPECT_EQ(variant(t[0], "paper").light, LightLaw::kMean);
    EXPECT_EQ(variant(t[1], "paper").light, LightLaw::kConserved);
    EXPECT_EQ(variant(t[2], "paper").light, LightLaw::kLayers);
    EXPECT_EQ(variant(t[3], "paper").light, LightLaw::kScaled);
    EXPECT_EQ(variant(t[4], "paper").light, LightLaw::kAdded);
}

// Sums in a format that ends at 1 are too bright, and are told apart: the hazard stays to be seen. The same
// sums in binary16 are not.
TEST(StressHazards, NarrowSumsAreToldApart) {
    // Dark and near: colour and weight both end at 1, and their quotient is white.
    StressInput input = layer_input("even", 3, 1);
    input.pixels[0].background = glm::vec3(0.0f);
    for (Fragment& f : input.pixels[0].fragments) {
        f.z *= 0.01f;
        f.a = 0.9f;
        f.r = f.g = f.b = 0.09f;
    }
    const StressTechnique technique = stress_techniques({"weighted_blended"}, true).front();
    const std::vector<StressResult> results = stress_results(technique, input, 0);
    std::uint64_t faults = 0;
    for (std::size_t i = 0; i < results.size(); ++i) {
        const bool narrow = !technique.variants[i].narrow.empty();
        EXPECT_EQ(results[i].hazard, narrow ? StressHazard::kFormat : StressHazard::kNone)
            << technique.variants[i].formats;
        if (narrow) {
            faults += results[i].faults.all();
        } else {
            EXPECT_EQ(results[i].faults.all(), 0u) << technique.variants[i].formats;
        }
    }
    EXPECT_GT(faults, 0u);
}

// Colours above 1 are too wide for layers that end there, and light without alpha for what is scaled.
TEST(StressHazards, DependOnTheScene) {
    const auto hazard = [](const std::string& technique, const StressInput& input) {
        return stress_results(stress_techniques({technique}, false).front(), input, 0)[0].hazard;
    };
    EXPECT_EQ(hazard("k_buffer", layer_input("even", 10, 1)), StressHazard::kNone);
    EXPECT_EQ(hazard("k_buffer", layer_input("bright", 10, 1)), StressHazard::kFormat);
    StressInput glowing = layer_input("even", 10, 1);
    EXPECT_EQ(hazard("moment_based", glowing), StressHazard::kNone);
    glowing.pixels[0].fragments[0].a = 0;
    EXPECT_EQ(hazard("moment_based", glowing), StressHazard::kLight);
    EXPECT_EQ(hazard("alpha_blend", glowing), StressHazard::kNone);
}

TEST(StressStudy, FaultsAreThoseOfCombinationsWithoutAHazard) {
    StressStudy study;
    StressResult result;
    result.faults.infinite = 3;
    result.hazard = StressHazard::kFormat;
    study.results.push_back(result);
    EXPECT_EQ(study.faults().all(), 0u);
    EXPECT_EQ(study.held(), 0u);
    study.results[0].faults.negative = 1;  // no format's width explains it
    EXPECT_EQ(study.faults().all(), 1u);
    study.results[0].faults.negative = 0;
    result.hazard = StressHazard::kNone;
    result.faults.negative = 1;
    study.results.push_back(result);
    EXPECT_EQ(study.faults().all(), 4u);
    EXPECT_EQ(study.faults().negative, 1u);
    EXPECT_EQ(study.held(), 1u);
}

TEST(StressPage, TablesStandBetweenTheirMarks) {
    const std::string page =
        "before\n<!-- stress a -->\nold\n<!-- end a -->\nbetween\n<!-- stress b -->\n<!-- end b -->\n";
    EXPECT_EQ(
        with_stress_blocks(page, "page", {{"a", "new\n"}, {"c", "none\n"}}),
        "before\n<!-- stress a -->\n\nnew\n\n<!-- end a -->\nbetween\n<!-- stress b -->\n<!-- end b -->\n");
    const std::string once = with_stress_blocks(page, "page", {{"b", "x\n"}});
    EXPECT_EQ(with_stress_blocks(once, "page", {{"b", "x\n"}}), once);
    EXPECT_THROW(with_stress_blocks(page, "page", {{"c", ""}}), UserError);
    EXPECT_THROW(with_stress_blocks("<!-- stress a -->\n", "page", {{"a", ""}}), UserError);
    const std::vector<std::string_view> names{"a", "c"};
    EXPECT_NO_THROW(check_stress_page(page, "page", names));
    EXPECT_THROW(check_stress_page(page, "page", std::span(names).last(1)), UserError);
    EXPECT_THROW(check_stress_page("<!-- stress a -->\n", "page", names), UserError);
}

}  // namespace
}  // namespace ropsim
