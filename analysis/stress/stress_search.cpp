#include "analysis/stress/stress_search.h"

#include "analysis/progress.h"
#include "analysis/standard_techniques.h"
#include "analysis/stress/light_bound.h"
#include "analysis/stress/stress_inputs.h"
#include "analysis/stress/stress_moves.h"
#include "analysis/stress/stress_variants.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"
#include "rop/double_reading/double_pixel.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace ropsim {
namespace {

// Of the random pixels, those that the search begins with and those held against it: a hundred on average.
constexpr std::uint32_t kMostRandom = 199;
constexpr std::uint32_t kFewRandom = 24;   // of every other one that the search begins with
constexpr std::uint32_t kBrightShare = 4;  // one pixel in so many is bright
// One evaluation in so many is of a random pixel. The worst of those found lineages; half of them die out
// every so often, so that one that had a good start does not take all.
constexpr std::uint64_t kRandomShare = 2;
constexpr std::size_t kLineages = 8;
constexpr std::uint64_t kHalvings = 4;

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
bool may_be_bright(StressGoal goal) {
    return goal != StressGoal::kRounding;
}

struct Candidate {
    double error = -1;
    PixelScene pixel;
};

// Leaves out what does not make it any less bad: runs of fragments, then single ones.
void shrink(StressedPixel& stressed, StressGoal goal, Candidate& worst) {
    for (std::size_t length = worst.pixel.fragments.size() / 2; length > 0; length /= 2)
        for (std::size_t first = 0; first + length <= worst.pixel.fragments.size();) {
            if (length == worst.pixel.fragments.size()) break;
            PixelScene fewer = worst.pixel;
            const auto from = fewer.fragments.begin() + static_cast<std::ptrdiff_t>(first);
            fewer.fragments.erase(from, from + static_cast<std::ptrdiff_t>(length));
            for (std::uint32_t i = 0; i < fewer.fragments.size(); ++i) fewer.fragments[i].primitive = i;
            const double error = stressed.error(fewer, goal);
            if (error >= worst.error)
                worst = {error, std::move(fewer)};
            else
                first += length;
        }
}

// The lineages that random pixels found, the worst first.
std::vector<Candidate> founders(const StressSearch& search, StressedPixel& stressed, StressGoal goal,
                                std::uint64_t task, std::uint64_t count) {
    std::vector<Candidate> kept;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t key = key_of(search, task, i);
        PixelScene pixel =
            random_pixel(key, i % 2 == 0 ? kMostRandom : kFewRandom, may_be_bright(goal) && is_bright(key));
        const double error = stressed.error(pixel, goal);
        if (kept.size() == kLineages && error <= kept.back().error) continue;
        const auto at = std::ranges::upper_bound(kept, error, std::greater<>(), &Candidate::error);
        kept.insert(at, {error, std::move(pixel)});
        if (kept.size() > kLineages) kept.pop_back();
    }
    return kept;
}

// One goal of one technique.
WorstPixel searched(const StressSearch& search, StressedPixel& stressed, const std::string& technique,
                    StressGoal goal, std::uint64_t task) {
    const std::uint64_t random = std::max<std::uint64_t>(search.evaluations / kRandomShare, kLineages);
    const std::uint64_t each = (search.evaluations - std::min(random, search.evaluations)) / kHalvings;
    std::vector<Candidate> lineages = founders(search, stressed, goal, task, random);
    std::uint64_t draw = random;
    for (std::uint64_t phase = 0; phase < kHalvings; ++phase) {
        for (std::uint64_t i = 0; i < each; ++i) {
            Draws draws(key_of(search, task, draw++));
            Candidate& own = lineages[i % lineages.size()];
            const PixelScene& other =
                lineages[draws.below(static_cast<std::uint32_t>(lineages.size()))].pixel;
            PixelScene pixel = changed(draws, own.pixel, other, may_be_bright(goal));
            const double error = stressed.error(pixel, goal);
            if (error >= own.error) own = {error, std::move(pixel)};
        }
        std::ranges::stable_sort(lineages, std::greater<>(), &Candidate::error);
        lineages.resize(std::max<std::size_t>(lineages.size() / 2, 1));
    }
    shrink(stressed, goal, lineages.front());
    WorstPixel worst;
    worst.technique = technique;
    worst.goal = goal;
    worst.error = lineages.front().error;
    worst.pixel = std::move(lineages.front().pixel);
    worst.evaluations = draw;
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
    return largest_difference(exact, other) / light_of(pixel).scale;
}

std::array<double, 3> StressedPixel::errors(const PixelScene& pixel) {
    const std::array<double, 3> exact = double_->run(pixel);
    const double scale = light_of(pixel).scale;
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
