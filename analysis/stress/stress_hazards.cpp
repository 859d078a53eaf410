#include "analysis/stress/stress_hazards.h"

#include "analysis/stress/stress_inputs.h"
#include "analysis/stress/stress_tables.h"
#include "rop/double_reading/double_pixel.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <fmt/format.h>

namespace ropsim {
namespace {

using Color = std::array<float, 3>;
constexpr Color kBlack{0, 0, 0};
constexpr Color kWhite{1, 1, 1};
constexpr double kStep = 1.0 / 255;

void add(PixelScene& scene, float z, float alpha, const Color& color) {
    scene.fragments.push_back({z, alpha * color[0], alpha * color[1], alpha * color[2], alpha, 0, 0,
                               static_cast<std::uint32_t>(scene.fragments.size()), 1, 0});
}
PixelScene before(float background) {
    PixelScene scene;
    scene.background = glm::vec3(background);
    return scene;
}
// At even depths, the nearest first, before white: of black layers what comes out is the transmittance.
PixelScene layers(int count, float alpha, const Color& color = kBlack, float depth = 1.0f) {
    PixelScene scene = before(1);
    for (int i = 0; i < count; ++i)
        add(scene, depth * static_cast<float>(i + 1) / static_cast<float>(count + 1), alpha, color);
    return scene;
}
PixelScene two(float z0, float alpha0, const Color& color0, float z1, float alpha1, const Color& color1) {
    PixelScene scene = before(0);
    add(scene, z0, alpha0, color0);
    add(scene, z1, alpha1, color1);
    return scene;
}
// Of random depth, alpha and colour.
std::vector<PixelScene> random_scenes(int count, std::size_t fragments) {
    std::vector<PixelScene> scenes;
    for (int i = 0; i < count; ++i) {
        PixelScene scene = layer_input("bright", fragments, static_cast<std::uint64_t>(i)).pixels[0];
        for (Fragment& f : scene.fragments) {
            f.r /= 64;
            f.g /= 64;
            f.b /= 64;
        }
        scenes.push_back(std::move(scene));
    }
    return scenes;
}
// Half of them red, the others blue.
PixelScene red_then_blue(int count, float alpha) {
    PixelScene scene = layers(count, alpha, {1, 0, 0});
    for (std::size_t i = scene.fragments.size() / 2; i < scene.fragments.size(); ++i)
        std::swap(scene.fragments[i].r, scene.fragments[i].b);
    for (Fragment& f : scene.fragments) f.z = 0.999f;
    return scene;
}

Color mean_color(const std::string& technique, const TraceHeader& header, const PixelScene& scene, int seeds,
                 bool in_double) {
    std::array<double, 3> sum{};
    for (int seed = 0; seed < seeds; ++seed) {
        const auto key = static_cast<std::uint64_t>(seed);
        const auto pixel = in_double ? ropsim_double::make_single_pixel(technique, header, key)
                                     : make_single_pixel(technique, header, key);
        const std::array<double, 3> color = pixel->run(scene);
        for (std::size_t c = 0; c < 3; ++c) sum[c] += color[c] / seeds;
    }
    return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
}

std::vector<StressHazardCase> stored_products() {
    return {
        {.id = "revealage_stalls",
         .what = "8-bit revealage stalls at 0.5/a codes: a = .01 at 50 of 255 for ever",
         .with = "weighted_blended:format=float32,revealage_format=unorm8",
         .cured = "weighted_blended:format=float32,revealage_format=float16",
         .scenes = {layers(4096, 0.01f)},
         .least_lost = 45 * kStep,
         .most_left = kStep},
        {.id = "revealage_never_moves",
         .what = "8-bit revealage never moves for alpha below 1/510",
         .with = "weighted_blended:format=float32,revealage_format=unorm8",
         .cured = "weighted_blended:format=float32,revealage_format=unorm24",
         .scenes = {layers(4096, 0.00195f)},
         .least_lost = 0.9,
         .most_left = kStep},
        {.id = "coverage_stalls",
         .what = "8-bit beta stalls like revealage",
         .with = "phenomenological:form=alpha",
         .cured = "phenomenological:form=alpha,beta_format=float16",
         .scenes = {layers(4096, 0.01f)},
         .least_lost = 45 * kStep,
         .most_left = kStep},
        {.id = "truncation_darkens",
         .what = "8-bit transmittance cut off at each store darkens thin media: .22 for .70",
         .with = "aoit",
         .cured = "aoit:transmittance_format=float16,transmittance_rounding=nearest",
         .scenes = {layers(200, 0.0018f)},
         .least_lost = 0.4,
         .most_left = kStep},
        {.id = "thin_layers_vanish",
         .what = "fragments of alpha below 1/510 are no layer in 8 bits",
         .with = "mlab:layers=4,format=float32,transmittance_format=unorm8",
         .cured = "mlab:layers=4,format=float32,transmittance_format=unorm16",
         .scenes = {layers(300, 0.0019f)},
         .least_lost = 0.3,
         .most_left = kStep},
        {.id = "thin_list_vanishes",
         .what = "the same of lists with 8-bit colour and alpha",
         .with = "a_buffer",
         .cured = "a_buffer:color_format=unorm16",
         .scenes = {layers(300, 0.0019f)},
         .least_lost = 0.3,
         .most_left = kStep},
    };
}

std::vector<StressHazardCase> stored_sums() {
    return {
        {.id = "half_sums_stand_still",
         .what = "binary16 sums stand still at 2048 times a term: 100,000 layers",
         .with = "weighted_blended:weight=none,format=float32,color_format=float16",
         .cured = "weighted_blended:weight=none,format=float32",
         .scenes = {layers(100'000, 0.01f, {0.3f, 0.3f, 0.3f})},
         .reference = "weighted_blended:weight=none,format=float32",
         .least_lost = kStep,
         .most_left = kStep},
        {.id = "small_weights_stand_still",
         .what = "the same of the least weight, .01: of 4,096 layers the last do not count",
         .with = "phenomenological:form=alpha,format=float32,accumulated_format=float16",
         .cured = "phenomenological:form=alpha,format=float32",
         .scenes = {red_then_blue(4096, 0.01f)},
         .reference = "phenomenological:form=alpha,format=float32",
         .least_lost = 0.02,
         .most_left = kStep},
        {.id = "bright_sums_overflow",
         .what = "binary16 sums of bright layers near the eye overflow (weights of equation 10): white",
         .with = "weighted_blended",
         .cured = "weighted_blended:color_format=float32",
         .scenes = {layers(64, 0.9f, {10, 10, 10}, 0.01f)},
         .reference = "weighted_blended:format=float32",
         .least_lost = 5,
         .most_left = 10 * kStep},
        {.id = "sums_end_at_one",
         .what = "visible colour exceeds 1 before it is corrected: a fixed-point accumulator cuts it off",
         .with = "stochastic:samples=8,method=depth_based,correction=accumulated,accumulation_format=unorm16",
         .cured = "stochastic:samples=8,method=depth_based,correction=accumulated",
         .scenes = {layers(16, 0.5f, kWhite, 0.0f)},
         .seeds = 64,
         .reference = "stochastic:samples=8,method=depth_based,correction=accumulated,format=float32",
         .least_lost = 2 * kStep,
         .most_left = kStep},
        {.id = "map_sums_end_at_one",
         .what = "absorbance exceeds 1: a fixed-point map lets through what is hidden",
         .with = "opacity_map:format=float32,slices_format=unorm16",
         .cured = "opacity_map:format=float32,slices_format=float16",
         .scenes = {layers(32, 0.5f, kWhite)},
         .reference = "opacity_map:format=float32",
         .least_lost = 10 * kStep,
         .most_left = kStep},
        {.id = "tail_wraps",
         .what = "sums in 10 bits wrap above 4",
         .with = "hybrid:layers=2,tail_format=packed_wrapping",
         .cured = "hybrid:layers=2,tail_format=float16",
         .scenes = {layers(12, 0.5f, kWhite)},
         .reference = "hybrid:layers=2,format=float32",
         .least_lost = 10 * kStep,
         .most_left = kStep},
        {.id = "narrow_moments",
         .what = "moments in 16 bits: 4 to 8 times the error on two layers",
         .with = "moment_based:moments=6,moment_format=unorm16",
         .cured = "moment_based:moments=6",
         .scenes = random_scenes(500, 2),
         .least_lost = 2 * kStep,
         .most_left = 2 * kStep},
        {.id = "bright_colors_end_at_one",
         .what = "8-bit layers cut off colours above 1",
         .with = "k_buffer",
         .cured = "k_buffer:color_format=float16",
         .scenes = {layers(4, 0.5f, {4, 2, 0.5f})},
         .least_lost = 1,
         .most_left = 4 * kStep},
    };
}

std::vector<StressHazardCase> arithmetic() {
    return {
        {.id = "lone_fragment_vanishes",
         .what = "a lone fragment makes the moments' matrix singular and is lost",
         .with = "moment_based:guard=published",
         .cured = "moment_based",
         .scenes = random_scenes(500, 1),
         .least_lost = 10 * kStep,
         .most_left = kStep},
        {.id = "thin_pixel_is_skipped",
         .what = "absorbance below .001 is taken as an empty pixel",
         .with = "moment_based:guard=published,format=float32",
         .cured = "moment_based:format=float32",
         .scenes = {layers(1, 0.0009f, {64, 64, 64})},
         .least_lost = 10 * kStep,
         .most_left = kStep},
        {.id = "ringing_brightens",
         .what = "the Fourier series rings: transmittance above 1 behind thin layers",
         .with = "fourier_map:clamp=off,format=float32",
         .cured = "fourier_map:clamp=on,format=float32",
         .scenes = {two(0.2f, 0.5f, kBlack, 0.8f, 0.99f, kWhite), layers(3, 0.98f, kWhite)},
         .least_lost = 5 * kStep,
         .most_left = 1},
        {.id = "light_is_scaled",
         .what = "light without alpha is scaled with the sum to the total alpha",
         .with = "opacity_map:composite=normalised,format=float32",
         .cured = "opacity_map:composite=plain,format=float32",
         .scenes = {[] {
             PixelScene scene = two(0.5f, 1.0f, kWhite, 0.51f, 1.0f, kWhite);
             add(scene, 0.1f, 0.0f, kBlack);
             scene.fragments.back().r = scene.fragments.back().g = scene.fragments.back().b = 0.1f;
             return scene;
         }()},
         .least_lost = 0.5,
         .most_left = 1},
    };
}

std::vector<StressHazardCase> approximation() {
    return {
        {.id = "coplanar_layers_add",
         .what = "fragments of one depth do not hide one another: two of alpha .5 show 1 for .75",
         .with = "adaptive:nodes=8,format=float32",
         .cured = "adaptive:nodes=8,format=float32,equal_depth=merge",
         .scenes = {two(0.5f, 0.5f, kWhite, 0.5f, 0.5f, kWhite)},
         .least_lost = 0.2,
         .most_left = 0.2},
        {.id = "underestimation_darkens",
         .what = "underestimated visibility adds up to less than alpha: 200 white layers of .01",
         .with = "adaptive:nodes=8,format=float32",
         .cured = "adaptive:nodes=8,format=float32,composite=normalised",
         .scenes = {layers(200, 0.01f, kWhite)},
         .least_lost = 20 * kStep,
         .most_left = kStep},
        {.id = "tail_without_its_alpha",
         .what = "the tail's mean colour without its alpha is added in full",
         .with = "hybrid:layers=2,format=float32,tail_factor=off",
         .cured = "hybrid:layers=2,format=float32",
         .scenes = random_scenes(500, 3),
         .least_lost = 15 * kStep,
         .most_left = kStep},
        {.id = "overflow_is_dropped",
         .what = "what falls out of a k-buffer is lost",
         .with = "k_buffer:layers=4,format=float32",
         .cured = "k_buffer:layers=16,format=float32",
         .scenes = {layers(12, 0.2f)},
         .least_lost = 0.2,
         .most_left = kStep},
        {.id = "merged_layer_is_too_near",
         .what = "a merged layer keeps the nearer depth: a fragment between comes to lie behind",
         .with = "mlab:layers=2,format=float32",
         .cured = "mlab:layers=4,format=float32",
         .scenes = {[] {
             PixelScene scene = before(0);
             add(scene, 0.1f, 0.1f, kBlack);
             add(scene, 0.2f, 0.5f, kBlack);
             add(scene, 0.8f, 0.9f, kBlack);
             add(scene, 0.5f, 0.8f, kWhite);
             return scene;
         }()},
         .least_lost = 0.2,
         .most_left = kStep},
        {.id = "thin_alpha_is_never_inserted",
         .what = "alpha below 1/2b rounds to no bit and is never inserted",
         .with = "slab:layers=8,bits=16,format=float32",
         .cured = "slab:layers=8,bits=1024,format=float32",
         .scenes = {layers(8, 0.03f)},
         .seeds = 256,
         .least_lost = 0.2,
         .most_left = 2 * kStep},
        {.id = "coplanar_layers_collapse",
         .what = "peeling keeps one layer of each depth",
         .with = "depth_peeling:ties=collapse,format=float32",
         .cured = "depth_peeling:ties=primitive,format=float32",
         .scenes = {two(0.5f, 0.5f, kWhite, 0.5f, 0.5f, kWhite)},
         .least_lost = 0.2,
         .most_left = kStep},
        {.id = "masks_correlate",
         .what = "fixed masks of alpha to coverage: equal layers hide one another",
         .with = "stochastic:samples=8,masks=alpha_to_coverage,format=float32",
         .cured = "stochastic:samples=8,format=float32",
         .scenes = {layers(2, 0.5f)},
         .seeds = 4096,
         .least_lost = 0.2,
         .most_left = 4 * kStep},
        {.id = "same_seed_occludes",
         .what = "fragments of one seed have one mask: they hide one another",
         .with = "stochastic:samples=8,seed_from=object,format=float32",
         .cured = "stochastic:samples=8,format=float32",
         .scenes = {layers(2, 0.5f)},
         .seeds = 4096,
         .least_lost = 0.2,
         .most_left = 4 * kStep},
        {.id = "radical_inverse_is_biased",
         .what = "plain radical inverses correlate from surface to surface",
         .with = "laine_karras:samples=8,hash=radical_inverse,format=float32",
         .cured = "laine_karras:samples=8,format=float32",
         .scenes = {layers(8, 0.1f)},
         .seeds = 4096,
         .least_lost = 0.3,
         .most_left = 4 * kStep},
        {.id = "few_samples_are_empty",
         .what = "pixels of alpha below 1/S are empty or too full: noise of one seed",
         .with = "stochastic:samples=4,format=float32",
         .cured = "stochastic:samples=8,method=depth_based,correction=accumulated,format=float32",
         .scenes = std::vector<PixelScene>(64, layers(1, 0.1f)),
         .least_lost = 5 * kStep,
         .most_left = kStep},
    };
}

}  // namespace

const std::vector<StressHazardCase>& stress_hazard_cases() {
    static const std::vector<StressHazardCase> list = [] {
        std::vector<StressHazardCase> all;
        for (const auto& part : {stored_products(), stored_sums(), arithmetic(), approximation()})
            all.insert(all.end(), part.begin(), part.end());
        return all;
    }();
    return list;
}

StressHazardOutcome run_hazard(const StressHazardCase& hazard) {
    const TraceHeader header = layer_input("even", 1, 0).header;
    StressHazardOutcome outcome;
    for (const PixelScene& scene : hazard.scenes) {
        Color expected;
        if (hazard.reference.empty()) {
            const std::array<double, 3> exact = exact_color(scene);
            for (std::size_t c = 0; c < 3; ++c) expected[c] = static_cast<float>(exact[c]);
        } else {
            expected = mean_color(hazard.reference, header, scene, hazard.seeds, true);
        }
        const Color bad = mean_color(hazard.with, header, scene, hazard.seeds, false);
        const Color good = mean_color(hazard.cured, header, scene, hazard.seeds, false);
        for (std::size_t c = 0; c < 3; ++c) {
            outcome.lost += std::pow(static_cast<double>(bad[c]) - static_cast<double>(expected[c]), 2);
            outcome.left += std::pow(static_cast<double>(good[c]) - static_cast<double>(expected[c]), 2);
        }
    }
    const double values = 3 * static_cast<double>(hazard.scenes.size());
    outcome.lost = std::sqrt(outcome.lost / values);
    outcome.left = std::sqrt(outcome.left / values);
    outcome.bits = make_single_pixel(hazard.with, header, 0)->technique().bits;
    outcome.more = make_single_pixel(hazard.cured, header, 0)->technique().bits - outcome.bits;
    return outcome;
}

std::string stress_hazards_markdown() {
    std::string text =
        "\n## Hazards and cures\n\nErrors in units of 1/255, root mean square of a channel over the hazard's "
        "pixels.\n\n";
    add_heading(text, {"hazard", "with", "lost", "cured by", "left", "bits", "bits more"});
    for (const StressHazardCase& hazard : stress_hazard_cases()) {
        const StressHazardOutcome outcome = run_hazard(hazard);
        add_row(text, {hazard.what, fmt::format("`{}`", hazard.with), in_255(outcome.lost),
                       fmt::format("`{}`", hazard.cured), in_255(outcome.left), std::to_string(outcome.bits),
                       fmt::format("{:+}", outcome.more)});
    }
    return text;
}

}  // namespace ropsim
