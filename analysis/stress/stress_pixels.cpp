#include "analysis/stress/stress_pixels.h"

#include "analysis/stress/largest.h"
#include "base/random.h"
#include "rop/double_reading/double_pixel.h"
#include "rop/registry.h"
#include "rop/single_pixel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ropsim {
namespace {

// What is asked of the first pixels of an input alone, and of lists no longer than this.
constexpr std::size_t kPixelsAskedMore = 16;
constexpr std::size_t kFragmentsAskedMore = 20'000;
constexpr std::size_t kDepthsAsked = 48;
// Rounds of peeling times fragments, and fragments that walk each other, that one pixel may cost.
constexpr std::size_t kMostPeeled = 2'000;
constexpr std::int64_t kFewLayers = 64;

std::vector<float> asked_depths(const PixelScene& pixel) {
    std::vector<float> depths;
    for (const Fragment& f : pixel.fragments) depths.push_back(f.z);
    std::ranges::sort(depths);
    std::vector<float> asked{0.0f};
    const std::size_t count = std::min(depths.size(), kDepthsAsked);
    for (std::size_t i = 0; i < count; ++i) {
        const float z = depths[i * depths.size() / count];
        for (const float near : {std::nextafter(z, -1.0f), z, std::nextafter(z, 2.0f)})
            if (near >= asked.back() && near <= 1.0f) asked.push_back(near);
    }
    asked.push_back(1.0f);
    return asked;
}

bool has_equal_depths(const PixelScene& pixel) {
    std::vector<float> depths;
    for (const Fragment& f : pixel.fragments) depths.push_back(f.z);
    std::ranges::sort(depths);
    return std::ranges::adjacent_find(depths) != depths.end();
}

// Largest change of a channel with the fragments turned round and with them shuffled.
double order_change(SinglePixel& technique, const PixelScene& pixel, const std::array<double, 3>& color) {
    PixelScene other = pixel;
    double most = 0;
    const auto compare = [&] {
        const std::array<double, 3> changed = technique.run(other);
        for (std::size_t c = 0; c < 3; ++c) take_larger(most, std::abs(changed[c] - color[c]));
    };
    std::ranges::reverse(other.fragments);
    compare();
    for (std::size_t i = other.fragments.size(); i > 1; --i)
        std::swap(other.fragments[i - 1], other.fragments[mix64(i) % i]);
    compare();
    return most;
}

// The channel farthest from 1 of the same fragments, every surface and the background white.
double white(SinglePixel& technique, const PixelScene& pixel) {
    PixelScene scene = pixel;
    scene.background = glm::vec3(1.0f);
    for (Fragment& f : scene.fragments) f.r = f.g = f.b = f.a;
    const std::array<double, 3> color = technique.run(scene);
    double farthest = color[0];
    for (const double c : color)
        if (is_larger(std::abs(c - 1), std::abs(farthest - 1))) farthest = c;
    return farthest;
}

}  // namespace

InputOutcome run_pixels(const std::string& technique, Precision precision, const StressInput& input,
                        std::uint64_t seed) {
    const std::unique_ptr<SinglePixel> single =
        precision == Precision::kSingle ? make_single_pixel(technique, input.header, seed)
                                        : ropsim_double::make_single_pixel(technique, input.header, seed);
    InputOutcome outcome;
    outcome.random = single->technique().random;
    for (const PixelScene& pixel : input.pixels) {
        PixelOutcome& out = outcome.pixels.emplace_back();
        out.color = single->run(pixel);
        out.paths = single->paths();
        if (outcome.pixels.size() > kPixelsAskedMore || !input.physical) continue;
        if (single->technique().visibility && pixel.fragments.size() <= kFragmentsAskedMore) {
            const std::vector<float> depths = asked_depths(pixel);
            out.visibility.resize(depths.size());
            single->visibility(depths, out.visibility);
        }
        if (pixel.fragments.size() > kFragmentsAskedMore) continue;
        if (precision == Precision::kSingle && single->technique().any_order && pixel.fragments.size() > 1 &&
            !has_equal_depths(pixel))
            out.order_change = order_change(*single, pixel, out.color);
        out.white = white(*single, pixel);
    }
    return outcome;
}

bool takes_too_long(const std::string& technique, const StressInput& input) {
    TechniqueSpec spec = parse_technique(technique, "--technique");
    const bool peels = spec.name == "depth_peeling" || spec.name == "dual_depth_peeling";
    const bool walks = technique.find("iterative") != std::string::npos;
    const bool long_walk = peels && spec.parameters.get_integer("layers", 4096, 1, 4096) > kFewLayers;
    return (walks || long_walk) && input.most_fragments() > kMostPeeled;
}

}  // namespace ropsim
