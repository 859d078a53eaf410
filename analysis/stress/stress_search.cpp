#include "analysis/stress/stress_search.h"

#include "analysis/progress.h"
#include "analysis/standard_techniques.h"
#include "analysis/stress/stress_inputs.h"
#include "analysis/stress/stress_variants.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"
#include "rop/double_reading/double_pixel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ropsim {
namespace {

constexpr std::uint32_t kMostSearched = 48;  // fragments of a pixel that the search may grow to
constexpr std::uint32_t kMostRandom = 199;   // of the random pixels afterwards: a hundred on average
constexpr float kBrightest = 64;
constexpr std::uint32_t kBrightShare = 4;  // one pixel in so many is bright
// The search starts afresh so often, each time from the worst of some random pixels: evolution stays near
// where it starts.
constexpr std::uint64_t kStarts = 8;
constexpr std::uint64_t kRandomShare = 4;  // one evaluation in so many is of a random pixel

// A stream of numbers.
class Draws {
 public:
    explicit Draws(std::uint64_t key) : key_(mix64(key)) {}
    float unit() { return random_unit(key_, next_++); }
    std::uint32_t below(std::uint32_t count) { return random_bits(key_, next_++) % count; }

 private:
    std::uint64_t key_;
    std::uint32_t next_ = 0;
};

float random_alpha(Draws& draws, std::uint32_t kind) {
    switch (kind) {
        case 0:
            return draws.unit();
        case 1:
            return std::exp2(-20.0f * draws.unit());
        case 2:
            return 1.0f - std::exp2(-20.0f * draws.unit());
        default:
            return draws.below(4) == 0 ? 1.0f : 0.3f * draws.unit();
    }
}
float random_depth(Draws& draws, std::uint32_t kind, float center) {
    switch (kind) {
        case 0:
            return draws.unit();
        case 1:
            return std::clamp(center + 1e-4f * (draws.unit() - 0.5f), 0.0f, 1.0f);
        case 2:
            return static_cast<float>(draws.below(9)) / 8;
        default:
            return 1.0f - std::exp2(-20.0f * draws.unit());
    }
}

// A fragment's straight colour is kept with it, so that a change of alpha leaves it.
Fragment fragment_of(float z, float a, const std::array<float, 3>& color, std::uint32_t primitive) {
    return {z, a * color[0], a * color[1], a * color[2], a, 0, 0, primitive, 1, 0};
}
std::array<float, 3> straight(const Fragment& f) {
    if (!(f.a > 0)) return {1, 1, 1};
    const auto channel = [&](float value) { return std::min(value / f.a, value > f.a ? kBrightest : 1.0f); };
    return {channel(f.r), channel(f.g), channel(f.b)};
}
std::array<float, 3> random_color(Draws& draws, float scale) {
    return {scale * draws.unit(), scale * draws.unit(), scale * draws.unit()};
}

void change_one(Draws& draws, PixelScene& pixel, bool bright) {
    const std::uint32_t at = draws.below(static_cast<std::uint32_t>(pixel.fragments.size()));
    Fragment& f = pixel.fragments[at];
    std::array<float, 3> color = straight(f);
    const float step = std::exp2(-12.0f * draws.unit()) * (draws.unit() - 0.5f);
    switch (draws.below(6)) {
        case 0:
            f.z = std::clamp(f.z + step, 0.0f, 1.0f);
            break;
        case 1:
            f.z = random_depth(draws, draws.below(4), pixel.fragments[draws.below(at + 1)].z);
            break;
        case 2:
            f = fragment_of(f.z, std::clamp(f.a + step, 0.0f, 1.0f), color, f.primitive);
            break;
        case 3:
            f = fragment_of(f.z, random_alpha(draws, draws.below(4)), color, f.primitive);
            break;
        case 4:
            color = random_color(draws, bright && draws.below(kBrightShare) == 0 ? kBrightest : 1.0f);
            f = fragment_of(f.z, f.a, color, f.primitive);
            break;
        default:
            color[draws.below(3)] = draws.below(2) == 0 ? 0.0f : 1.0f;
            f = fragment_of(f.z, f.a, color, f.primitive);
    }
}

PixelScene changed(Draws& draws, const PixelScene& from, bool bright) {
    PixelScene pixel = from;
    const std::uint32_t changes = 1 + draws.below(4);
    for (std::uint32_t i = 0; i < changes; ++i) {
        const auto count = static_cast<std::uint32_t>(pixel.fragments.size());
        switch (draws.below(8)) {
            case 0:
                if (count < kMostSearched) pixel.fragments.push_back(pixel.fragments[draws.below(count)]);
                break;
            case 1:
                if (count > 1) pixel.fragments.erase(pixel.fragments.begin() + draws.below(count));
                break;
            case 2:
                std::swap(pixel.fragments[draws.below(count)], pixel.fragments[draws.below(count)]);
                break;
            case 3:
                pixel.background[static_cast<int>(draws.below(3))] = draws.unit();
                break;
            default:
                change_one(draws, pixel, bright);
        }
    }
    for (std::uint32_t i = 0; i < pixel.fragments.size(); ++i) pixel.fragments[i].primitive = i;
    return pixel;
}

double largest_difference(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    double most = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const double difference = std::abs(a[c] - b[c]);
        if (!std::isfinite(difference)) return std::numeric_limits<double>::infinity();
        most = std::max(most, difference);
    }
    return most;
}

std::uint64_t key_of(const StressSearch& search, std::uint64_t task, std::uint64_t draw) {
    return mix64(mix64(search.seed + 77) ^ mix64(task << 40) ^ draw);
}

bool is_bright(std::uint64_t key) {
    return mix64(key) % kBrightShare == 0;
}

// One goal of one technique.
WorstPixel searched(const StressSearch& search, StressedPixel& stressed, const std::string& technique,
                    StressGoal goal, std::uint64_t task) {
    WorstPixel worst;
    worst.technique = technique;
    worst.goal = goal;
    worst.error = -1;
    const bool may_be_bright = goal != StressGoal::kRounding;
    const std::uint64_t each = std::max<std::uint64_t>(search.evaluations / kStarts, kRandomShare);
    for (std::uint64_t start = 0; start < kStarts; ++start) {
        PixelScene best;
        double most = -1;
        for (std::uint64_t i = 0; i < each; ++i) {
            const std::uint64_t key = key_of(search, task, start * each + i);
            Draws draws(key);
            const bool bright = may_be_bright && is_bright(key);
            PixelScene pixel = i < each / kRandomShare ? random_pixel(key, kMostSearched, bright)
                                                       : changed(draws, best, may_be_bright);
            const double error = stressed.error(pixel, goal);
            if (error < most) continue;
            most = error;
            best = std::move(pixel);
        }
        if (most > worst.error) {
            worst.error = most;
            worst.pixel = best;
        }
    }
    worst.evaluations = each * kStarts;
    return worst;
}

void try_random(const StressSearch& search, StressedPixel& stressed, std::vector<WorstPixel*>& goals,
                std::uint64_t task) {
    std::uint64_t fewest = 0;  // fragments of a goal so far
    for (std::uint64_t i = 0; fewest < search.random_fragments; ++i) {
        const std::uint64_t key = key_of(search, task, i);
        const bool bright = is_bright(key);
        const PixelScene pixel = random_pixel(key, kMostRandom, bright);
        const std::array<double, 3> errors = stressed.errors(pixel);
        for (WorstPixel* worst : goals) {
            if (bright && worst->goal == StressGoal::kRounding) continue;
            ++worst->random_pixels;
            worst->random_fragments += pixel.fragments.size();
            worst->random_error =
                std::max(worst->random_error, errors[static_cast<std::size_t>(worst->goal)]);
        }
        if (!bright) fewest += pixel.fragments.size();
    }
}

}  // namespace

PixelScene random_pixel(std::uint64_t key, std::uint32_t most_fragments, bool bright) {
    Draws draws(key);
    PixelScene pixel;
    const std::uint32_t count = 1 + draws.below(most_fragments);
    const std::uint32_t alphas = draws.below(4);
    const std::uint32_t depths = draws.below(4);
    const float center = draws.unit();
    const float scale = bright ? kBrightest : 1.0f;
    pixel.background = {draws.unit(), draws.unit(), draws.unit()};
    for (std::uint32_t i = 0; i < count; ++i) {
        const float z = random_depth(draws, depths, center);
        const float a = random_alpha(draws, alphas);
        pixel.fragments.push_back(fragment_of(z, a, random_color(draws, scale), i));
    }
    return pixel;
}

StressedPixel::StressedPixel(const std::string& technique, std::uint64_t seed) {
    header_.width = header_.height = 1;
    header_.camera = plain_camera();
    header_.draws.emplace_back().name = "pixel";
    const StressTechnique variants = stress_techniques({technique}, false).front();
    if (variants.exact.empty())
        throw UserError("--technique",
                        fmt::format("{} has no form in float32 to compare with; name another", technique));
    paper_ = make_single_pixel(technique, header_, seed);
    single_ = make_single_pixel(variants.exact, header_, seed);
    double_ = ropsim_double::make_single_pixel(variants.exact, header_, seed);
}

double StressedPixel::error(const PixelScene& pixel, StressGoal goal) {
    const std::array<double, 3> exact = double_->run(pixel);
    const std::array<double, 3> other = goal == StressGoal::kRounding     ? paper_->run(pixel)
                                        : goal == StressGoal::kArithmetic ? single_->run(pixel)
                                                                          : exact_color(pixel);
    return largest_difference(exact, other) / brightest(pixel);
}

std::array<double, 3> StressedPixel::errors(const PixelScene& pixel) {
    const std::array<double, 3> exact = double_->run(pixel);
    const double scale = brightest(pixel);
    return {largest_difference(exact, paper_->run(pixel)) / scale,
            largest_difference(exact, single_->run(pixel)) / scale,
            largest_difference(exact, exact_color(pixel)) / scale};
}

bool StressedPixel::is_color(const PixelScene& pixel) {
    const auto fine = [](double value) { return std::isfinite(value) && value >= 0; };
    return std::ranges::all_of(paper_->run(pixel), fine) && std::ranges::all_of(single_->run(pixel), fine);
}

std::vector<WorstPixel> search_worst_pixels(const StressSearch& search) {
    const std::size_t goals = kStressGoalNames.size();
    std::vector<WorstPixel> found(search.techniques.size() * goals);
    Progress progress(search.techniques.size());
    parallel_for(search.threads, static_cast<int>(search.techniques.size()), [&](int number) {
        const auto t = static_cast<std::size_t>(number);
        const std::string& technique = search.techniques[t];
        StressedPixel stressed(technique, search.seed);
        std::vector<WorstPixel*> own;
        for (std::size_t g = 0; g < goals; ++g) {
            found[t * goals + g] =
                searched(search, stressed, technique, static_cast<StressGoal>(g), t * goals + g);
            own.push_back(&found[t * goals + g]);
        }
        if (search.random_fragments > 0)
            try_random(search, stressed, own, search.techniques.size() * goals + t);
        progress.finished("search " + technique);
    });
    return found;
}

}  // namespace ropsim
