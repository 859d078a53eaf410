#include "analysis/stress/stress_study.h"

#include "analysis/progress.h"
#include "analysis/stress/largest.h"
#include "analysis/stress/light_bound.h"
#include "analysis/stress/stress_pixels.h"
#include "base/error.h"
#include "base/parallel.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

namespace ropsim {
namespace {

constexpr double kLargestFloat16 = 65504;

double difference(const std::array<double, 3>& a, const std::array<double, 3>& b, std::size_t c) {
    return std::abs(a[c] - b[c]);
}

double largest_rise(const std::vector<double>& visibility) {
    double rise = 0;
    for (std::size_t i = 1; i < visibility.size(); ++i) take_larger(rise, visibility[i] - visibility[i - 1]);
    return rise;
}

// What is known of an input's pixels whatever the technique.
struct PixelFacts {
    std::array<double, 3> exact{};
    double scale = 1;
    bool negative = false;  // some colour is
    PixelLight light;
};
struct InputFacts {
    std::vector<PixelFacts> pixels;
    bool bright = false;  // colours above 1, or light without alpha that comes on top of others
    bool glows = false;   // light without alpha
};
InputFacts facts_of(const StressInput& input) {
    InputFacts facts;
    for (const PixelScene& pixel : input.pixels) {
        PixelFacts& f = facts.pixels.emplace_back();
        for (const Fragment& fragment : pixel.fragments)
            f.negative = f.negative || !(fragment.r >= 0 && fragment.g >= 0 && fragment.b >= 0);
        if (!input.physical) continue;
        f.exact = exact_color(pixel);
        f.light = light_of(pixel);
        f.scale = f.light.scale;
        const double glow = f.light.without_alpha;
        facts.glows = facts.glows || glow > 0;
        facts.bright = facts.bright || f.scale + glow > 1;
    }
    return facts;
}

// What the formats cannot hold comes first: it is to be mended before the formula can be seen.
StressHazard hazard_of(const StressVariant& variant, const InputFacts& facts) {
    if (!(facts.bright ? variant.narrow_if_bright : variant.narrow).empty()) return StressHazard::kFormat;
    const bool adds = variant.light == LightLaw::kAdded;
    return adds || (variant.light == LightLaw::kScaled && facts.glows) ? StressHazard::kLight
                                                                       : StressHazard::kNone;
}

void count_faults(StressFaults& faults, const std::array<double, 3>& color, const PixelFacts& facts,
                  bool physical, const StressVariant& variant) {
    const double most = most_light(variant, facts.light);
    for (const double value : color) {
        if (std::isnan(value)) {
            ++faults.not_numbers;
        } else if (std::isinf(value) ||
                   (physical && std::abs(value) >= kLargestFloat16 && 2 * facts.scale < kLargestFloat16)) {
            ++faults.infinite;
        } else if (value < 0 && !facts.negative) {
            ++faults.negative;
        } else if (physical && value > most) {
            ++faults.too_bright;
        }
    }
}

class Accumulated {
 public:
    void add(double value) {
        take_larger(worst_, value);
        sum_ += value;
        ++count_;
    }
    double worst() const { return count_ == 0 ? -1 : worst_; }
    double mean() const { return count_ == 0 ? -1 : sum_ / static_cast<double>(count_); }

 private:
    double worst_ = 0;
    double sum_ = 0;
    std::size_t count_ = 0;
};

struct Compared {
    Accumulated error, rounding, algorithm, rise, rise_exact, outside, order, white, white_rounding;
};

void compare_visibility(Compared& compared, const PixelOutcome& own, const PixelOutcome* exact) {
    if (own.visibility.empty()) return;
    compared.rise.add(largest_rise(own.visibility));
    for (const double v : own.visibility)
        compared.outside.add(std::isnan(v) ? v : std::max({0.0, -v, v - 1}));
    if (exact != nullptr && !exact->visibility.empty())
        compared.rise_exact.add(largest_rise(exact->visibility));
}

void compare(Compared& compared, const PixelOutcome& own, const PixelOutcome* exact,
             const PixelFacts& facts) {
    for (std::size_t c = 0; c < 3; ++c) {
        compared.error.add(difference(own.color, facts.exact, c) / facts.scale);
        if (exact == nullptr) continue;
        compared.rounding.add(difference(own.color, exact->color, c) / facts.scale);
        compared.algorithm.add(difference(exact->color, facts.exact, c) / facts.scale);
    }
    compare_visibility(compared, own, exact);
    if (own.order_change >= 0) compared.order.add(own.order_change / facts.scale);
    if (own.white >= 0) compared.white.add(std::abs(own.white - 1));
    if (own.white >= 0 && exact != nullptr) compared.white_rounding.add(std::abs(own.white - exact->white));
}

StressResult judged(const InputOutcome& own, const InputOutcome* exact, const StressInput& input,
                    const InputFacts& facts, const StressVariant& variant) {
    StressResult result;
    result.hazard = hazard_of(variant, facts);
    Compared compared;
    for (std::size_t p = 0; p < own.pixels.size(); ++p) {
        const PixelFacts& pixel = facts.pixels[p];
        result.values += own.pixels[p].color.size();
        count_faults(result.faults, own.pixels[p].color, pixel, input.physical, variant);
        for (const double v : own.pixels[p].visibility) result.faults.not_numbers += std::isnan(v) ? 1 : 0;
        if (!input.physical) continue;
        const PixelOutcome* in_double = exact == nullptr ? nullptr : &exact->pixels[p];
        compare(compared, own.pixels[p], in_double, pixel);
        if (in_double != nullptr) result.other_paths += own.pixels[p].paths != in_double->paths ? 1 : 0;
    }
    result.worst_error = compared.error.worst();
    result.mean_error = compared.error.mean();
    result.worst_rounding = compared.rounding.worst();
    result.mean_rounding = compared.rounding.mean();
    result.worst_algorithm = compared.algorithm.worst();
    result.rise = compared.rise.worst();
    result.rise_exact = compared.rise_exact.worst();
    result.outside = compared.outside.worst();
    result.order_change = compared.order.worst();
    result.white_loss = compared.white.worst();
    result.white_rounding = compared.white_rounding.worst();
    return result;
}

std::vector<StressResult> results_of(const StressTechnique& technique, const StressInput& input,
                                     const InputFacts& facts, std::uint64_t seed) {
    std::vector<StressResult> results;
    if (takes_too_long(technique.settings, input)) {
        results.resize(technique.variants.size());
        for (StressResult& result : results) result.left_out = true;
        return results;
    }
    std::optional<InputOutcome> exact;
    if (!technique.exact.empty()) exact = run_pixels(technique.exact, Precision::kDouble, input, seed);
    for (const StressVariant& variant : technique.variants)
        results.push_back(judged(run_pixels(variant.technique, Precision::kSingle, input, seed),
                                 exact ? &*exact : nullptr, input, facts, variant));
    return results;
}

}  // namespace

std::size_t StressStudy::measured() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(results, [](const StressResult& r) { return !r.left_out; }));
}

std::size_t StressStudy::held() const {
    return static_cast<std::size_t>(std::ranges::count_if(
        results, [](const StressResult& r) { return !r.left_out && r.hazard == StressHazard::kNone; }));
}

StressFaults StressStudy::faults() const {
    StressFaults all;
    for (const StressResult& r : results) {
        StressFaults f = r.faults;
        // What a hazard explains, and nothing else.
        if (r.hazard != StressHazard::kNone) f.too_bright = 0;
        if (r.hazard == StressHazard::kFormat) f.infinite = 0;
        all += f;
    }
    return all;
}

std::vector<StressResult> stress_results(const StressTechnique& technique, const StressInput& input,
                                         std::uint64_t seed) {
    return results_of(technique, input, facts_of(input), seed);
}

StressStudy run_stress_study(std::vector<StressTechnique> techniques, std::vector<StressInput> inputs,
                             std::uint64_t seed, int threads) {
    const auto start = std::chrono::steady_clock::now();
    StressStudy study{std::move(techniques), std::move(inputs), {}, seed, 0};
    std::vector<InputFacts> facts;
    for (const StressInput& input : study.inputs) facts.push_back(facts_of(input));
    std::vector<std::vector<StressResult>> parts(study.techniques.size());
    Progress progress(study.techniques.size());
    parallel_for(threads, static_cast<int>(study.techniques.size()), [&](int task) {
        const auto t = static_cast<std::size_t>(task);
        const StressTechnique& technique = study.techniques[t];
        for (std::size_t i = 0; i < study.inputs.size(); ++i) {
            std::vector<StressResult> results = results_of(technique, study.inputs[i], facts[i], seed);
            for (std::size_t v = 0; v < results.size(); ++v) {
                results[v].technique = t;
                results[v].variant = v;
                results[v].input = i;
                parts[t].push_back(results[v]);
            }
        }
        std::ranges::stable_sort(parts[t], {}, &StressResult::variant);
        progress.finished(technique.settings);
    });
    for (const std::vector<StressResult>& part : parts)
        study.results.insert(study.results.end(), part.begin(), part.end());
    study.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return study;
}

}  // namespace ropsim
