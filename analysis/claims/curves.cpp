// Runs a technique on pixels and asks it for its visibility.
#include "analysis/claims/curves.h"

#include "base/error.h"
#include "base/random.h"
#include "traces/trace_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace ropsim {
namespace {

constexpr float kBehindAll = 2.0f;  // window depths end at 1

std::vector<std::uint32_t> nearest_first(const std::vector<Fragment>& fragments) {
    std::vector<std::uint32_t> order(fragments.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(
        order, [&](std::uint32_t a, std::uint32_t b) { return fragments[a].z < fragments[b].z; });
    return order;
}

struct Composite {
    std::array<double, 3> color{};
    double weights = 0;  // sum of alpha times visibility
};

// What the curve is held against: transmittance strictly in front of each fragment, and colour by sorting.
struct Exact {
    std::vector<double> in_front;
    Composite composite;
    double total = 1;
};

Exact exact_of(const std::vector<Fragment>& fragments) {
    Exact exact;
    exact.in_front.resize(fragments.size());
    double nearer = 1;  // than the depth at hand
    float z = -1;
    for (const std::uint32_t i : nearest_first(fragments)) {
        const Fragment& f = fragments[i];
        if (f.z > z) nearer = exact.total;
        z = f.z;
        exact.in_front[i] = nearer;
        exact.composite.color[0] += static_cast<double>(f.r) * exact.total;
        exact.composite.color[1] += static_cast<double>(f.g) * exact.total;
        exact.composite.color[2] += static_cast<double>(f.b) * exact.total;
        exact.total *= 1 - static_cast<double>(f.a);
    }
    exact.composite.weights = 1 - exact.total;
    return exact;
}

// Colours are premultiplied.
Composite composite_of(const std::vector<Fragment>& fragments, const std::vector<float>& visibility) {
    Composite sum;
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const auto visible = static_cast<double>(visibility[i]);
        sum.color[0] += static_cast<double>(fragments[i].r) * visible;
        sum.color[1] += static_cast<double>(fragments[i].g) * visible;
        sum.color[2] += static_cast<double>(fragments[i].b) * visible;
        sum.weights += static_cast<double>(fragments[i].a) * visible;
    }
    return sum;
}

struct Seen {
    std::vector<float> in_front;  // of each fragment
    std::vector<float> behind;
    double total = 1;
};

Seen see(const PixelFragments& pixel, const CurveStudyOptions& options) {
    TraceHeader header;
    header.width = pixel.x + 1;
    header.height = pixel.y + 1;
    header.samples = 1;
    PixelRun run(header, pixel, options.technique, options.seed);
    CHECK(run.has_visibility(), "{} keeps none", options.technique);
    // In ascending order, each fragment's depth and the next float behind it.
    const std::vector<std::uint32_t> order = nearest_first(pixel.fragments);
    std::vector<float> depths;
    for (const std::uint32_t i : order) {
        depths.push_back(pixel.fragments[i].z);
        depths.push_back(std::nextafter(pixel.fragments[i].z, kBehindAll));
    }
    depths.push_back(kBehindAll);
    std::vector<std::size_t> places(depths.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    std::ranges::stable_sort(places, [&](std::size_t a, std::size_t b) { return depths[a] < depths[b]; });
    std::vector<float> ascending;
    for (const std::size_t place : places) ascending.push_back(depths[place]);
    const std::vector<float> found = run.visibility(ascending);
    std::vector<float> values(depths.size());
    for (std::size_t i = 0; i < places.size(); ++i) values[places[i]] = found[i];
    Seen seen{std::vector<float>(order.size()), std::vector<float>(order.size()),
              static_cast<double>(values.back())};
    for (std::size_t i = 0; i < order.size(); ++i) {
        seen.in_front[order[i]] = values[2 * i];
        seen.behind[order[i]] = values[2 * i + 1];
    }
    return seen;
}

void shuffle(std::vector<Fragment>& fragments, std::uint64_t key) {
    for (std::size_t i = fragments.size(); i > 1; --i) {
        const auto j = static_cast<std::size_t>(
            static_cast<double>(random_unit(key, static_cast<std::uint32_t>(i))) * static_cast<double>(i));
        std::swap(fragments[i - 1], fragments[std::min(j, i - 1)]);
    }
}

// Sums over pixels.
struct Sums {
    double pixels = 0, fragments = 0, steps = 0, near_steps = 0, curve = 0, squares = 0;
};

void add_pixel(const PixelFragments& pixel, const CurveStudyOptions& options, CurveStudy& study, Sums& sums) {
    const Exact exact = exact_of(pixel.fragments);
    const Seen seen = see(pixel, options);
    const Composite composite = composite_of(pixel.fragments, seen.in_front);
    sums.pixels += 1;
    for (std::size_t c = 0; c < 3; ++c) {
        const double error = 255 * (composite.color[c] - exact.composite.color[c]);
        study.mean8 += error / 3;
        sums.squares += error * error / 3;
    }
    if (exact.composite.weights > 0) study.weights_over_alpha += composite.weights / exact.composite.weights;
    study.total_off = std::max(study.total_off, std::abs(seen.total - exact.total));
    const double factor = seen.total < 1 ? (1 - exact.total) / (1 - seen.total) : HUGE_VAL;
    if (exact.total < 1) study.correction_off = std::max(study.correction_off, std::abs(factor - 1));
    const std::vector<std::uint32_t> order = nearest_first(pixel.fragments);
    for (std::size_t rank = 0; rank < order.size(); ++rank) {
        const std::uint32_t i = order[rank];
        sums.fragments += 1;
        sums.curve += std::pow(static_cast<double>(seen.in_front[i]) - exact.in_front[i], 2);
        if (seen.in_front[i] == seen.behind[i]) continue;
        sums.steps += 1;
        if (2 * rank < order.size()) sums.near_steps += 1;
    }
    // The other orders, of the same fragments.
    std::array<double, 3> low = composite.color;
    std::array<double, 3> high = composite.color;
    PixelFragments other = pixel;
    for (int order_number = 1; order_number < options.orders; ++order_number) {
        const auto key =
            static_cast<std::uint64_t>(sums.pixels) * 4096 + static_cast<std::uint64_t>(order_number);
        shuffle(other.fragments, mix64(options.seed + mix64(key)));
        const Composite image = composite_of(other.fragments, see(other, options).in_front);
        for (std::size_t c = 0; c < 3; ++c) {
            low[c] = std::min(low[c], image.color[c]);
            high[c] = std::max(high[c], image.color[c]);
        }
    }
    for (std::size_t c = 0; c < 3; ++c) study.spread8 += 255 * (high[c] - low[c]) / 3;
}

}  // namespace

std::vector<PixelFragments> random_layers(int pixels, int layers, float alpha, std::uint64_t seed) {
    std::vector<PixelFragments> all(static_cast<std::size_t>(pixels));
    for (int p = 0; p < pixels; ++p) {
        PixelFragments& pixel = all[static_cast<std::size_t>(p)];
        for (int i = 0; i < layers; ++i) {
            const std::uint64_t key =
                mix64(mix64(seed) + static_cast<std::uint64_t>(p) * 65536 + static_cast<std::uint64_t>(i));
            Fragment f{};
            f.z = random_unit(key, 0);
            f.a = alpha;
            f.r = alpha * random_unit(key, 1);
            f.g = alpha * random_unit(key, 2);
            f.b = alpha * random_unit(key, 3);
            f.coverage = 1;
            f.primitive = static_cast<std::uint32_t>(i);
            pixel.fragments.push_back(f);
        }
        pixel.slopes.resize(pixel.fragments.size());
    }
    return all;
}

std::vector<PixelFragments> sampled_pixels(const std::string& trace, int pixels, std::uint32_t least) {
    TraceReader reader(trace);
    const auto width = static_cast<std::size_t>(reader.header().width);
    PixelLayers layers;
    measure_trace(reader, &layers);
    std::vector<std::size_t> deep;
    for (std::size_t i = 0; i < layers.visible.size(); ++i)
        if (layers.visible[i] >= least) deep.push_back(i);
    std::vector<PixelFragments> all;
    const std::size_t count = std::min(deep.size(), static_cast<std::size_t>(pixels));
    for (std::size_t i = 0; i < count; ++i) {
        // Evenly over the image, from the middle of each share.
        const std::size_t at = deep[(2 * i + 1) * deep.size() / (2 * count)];
        all.push_back(read_pixel(reader, static_cast<int>(at % width), static_cast<int>(at / width)));
        // On their own: which pixel it is only keys random draws.
        all.back().x %= 8;
        all.back().y %= 8;
        for (Fragment& f : all.back().fragments) {
            f.x = static_cast<std::uint16_t>(all.back().x);
            f.y = static_cast<std::uint16_t>(all.back().y);
        }
    }
    return all;
}

CurveStudy study_curves(const std::vector<PixelFragments>& pixels, const CurveStudyOptions& options) {
    CurveStudy study;
    Sums sums;
    for (const PixelFragments& pixel : pixels) add_pixel(pixel, options, study, sums);
    CHECK(sums.pixels > 0 && sums.fragments > 0);
    study.mean8 /= sums.pixels;
    study.rms8 = std::sqrt(sums.squares / sums.pixels);
    study.weights_over_alpha /= sums.pixels;
    study.curve_rms = std::sqrt(sums.curve / sums.fragments);
    study.near_half = sums.steps > 0 ? sums.near_steps / sums.steps : 0;
    study.spread8 /= sums.pixels;
    return study;
}

}  // namespace ropsim
