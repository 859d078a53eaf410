#include "analysis/stress/stress_moves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ropsim {
namespace {

constexpr float kBrightest = 64;
constexpr std::uint32_t kBrightColors = 4;  // of a bright pixel's new colours, one in so many is bright

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
std::array<float, 3> new_color(Draws& draws, bool bright) {
    return random_color(draws, bright && draws.below(kBrightColors) == 0 ? kBrightest : 1.0f);
}

void change_one(Draws& draws, PixelScene& pixel, bool bright) {
    const std::uint32_t at = draws.below(static_cast<std::uint32_t>(pixel.fragments.size()));
    Fragment& f = pixel.fragments[at];
    std::array<float, 3> color = straight(f);
    const float step = std::exp2(-12.0f * draws.unit()) * (draws.unit() - 0.5f);
    switch (draws.below(7)) {
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
            f = fragment_of(f.z, f.a, new_color(draws, bright), f.primitive);
            break;
        case 5: {  // next to another fragment, or at its depth
            const float beside =
                pixel.fragments[draws.below(static_cast<std::uint32_t>(pixel.fragments.size()))].z;
            const std::uint32_t side = draws.below(3);
            f.z =
                side == 0 ? beside : std::clamp(std::nextafter(beside, side == 1 ? -1.0f : 2.0f), 0.0f, 1.0f);
            break;
        }
        default:
            color[draws.below(3)] = draws.below(2) == 0 ? 0.0f : 1.0f;
            f = fragment_of(f.z, f.a, color, f.primitive);
    }
}

// Positions first..last of a list, last exclusive, not empty.
struct Run {
    std::ptrdiff_t first = 0;
    std::ptrdiff_t last = 0;
};
Run random_run(Draws& draws, std::size_t count) {
    const auto n = static_cast<std::uint32_t>(count);
    const std::uint32_t first = draws.below(n);
    // Short runs are as likely as long ones.
    const auto most = static_cast<float>(n - first);
    const auto length = static_cast<std::uint32_t>(std::exp2(draws.unit() * std::log2(most + 1)));
    return {static_cast<std::ptrdiff_t>(first),
            static_cast<std::ptrdiff_t>(std::min(n, first + std::max(length, 1u)))};
}

void insert_run(Draws& draws, std::vector<Fragment>& list, const std::vector<Fragment>& from) {
    const Run run = random_run(draws, from.size());
    const std::vector<Fragment> copy(from.begin() + run.first, from.begin() + run.last);
    const auto at = static_cast<std::ptrdiff_t>(draws.below(static_cast<std::uint32_t>(list.size() + 1)));
    list.insert(list.begin() + at, copy.begin(), copy.end());
    if (list.size() > kMostSearched) list.resize(kMostSearched);
}

// All fragments of a run take a value, or move by one step.
void change_run(Draws& draws, PixelScene& pixel, bool bright) {
    const Run run = random_run(draws, pixel.fragments.size());
    const std::uint32_t kind = draws.below(4);
    const float step = std::exp2(-8.0f * draws.unit()) * (draws.unit() - 0.5f);
    const std::array<float, 3> color = new_color(draws, bright);
    for (std::ptrdiff_t i = run.first; i < run.last; ++i) {
        Fragment& f = pixel.fragments[static_cast<std::size_t>(i)];
        if (kind == 0) f.z = std::clamp(f.z + step, 0.0f, 1.0f);
        if (kind == 1) f = fragment_of(f.z, std::clamp(f.a + step, 0.0f, 1.0f), straight(f), f.primitive);
        if (kind == 2) f = fragment_of(f.z, f.a, color, f.primitive);
        if (kind == 3)
            f = fragment_of(f.z, pixel.fragments[static_cast<std::size_t>(run.first)].a, straight(f),
                            f.primitive);
    }
}

void change_list(Draws& draws, std::vector<Fragment>& list, const PixelScene& other) {
    const auto count = static_cast<std::uint32_t>(list.size());
    switch (draws.below(8)) {
        case 0:
            if (count < kMostSearched) list.push_back(list[draws.below(count)]);
            break;
        case 1:
            if (count > 1) list.erase(list.begin() + draws.below(count));
            break;
        case 2:
            std::swap(list[draws.below(count)], list[draws.below(count)]);
            break;
        case 3:
            insert_run(draws, list, std::vector<Fragment>(list));
            break;
        case 4:
            insert_run(draws, list, other.fragments);
            break;
        case 5: {
            const Run run = random_run(draws, count);
            if (run.last - run.first < static_cast<std::ptrdiff_t>(count))
                list.erase(list.begin() + run.first, list.begin() + run.last);
            break;
        }
        case 6: {
            const Run run = random_run(draws, count);
            std::reverse(list.begin() + run.first, list.begin() + run.last);
            break;
        }
        default: {
            const Run run = random_run(draws, count);
            const bool nearest_first = draws.below(2) == 0;
            // Pointers are sorted, not fragments: std::stable_sort's buffer knows nothing of their alignment.
            const std::vector<Fragment> before(list.begin() + run.first, list.begin() + run.last);
            std::vector<const Fragment*> order;
            for (const Fragment& fragment : before) order.push_back(&fragment);
            std::ranges::stable_sort(order, [&](const Fragment* a, const Fragment* b) {
                return nearest_first ? a->z < b->z : b->z < a->z;
            });
            std::ranges::transform(order, list.begin() + run.first, [](const Fragment* f) { return *f; });
        }
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

PixelScene changed(Draws& draws, const PixelScene& from, const PixelScene& other, bool bright) {
    PixelScene pixel = from;
    const std::uint32_t changes = 1 + draws.below(4);
    for (std::uint32_t i = 0; i < changes; ++i) {
        switch (draws.below(8)) {
            case 0:
            case 1:
            case 2:
                change_list(draws, pixel.fragments, other);
                break;
            case 3:
                pixel.background[static_cast<int>(draws.below(3))] = draws.unit();
                break;
            case 4:
                change_run(draws, pixel, bright);
                break;
            default:
                change_one(draws, pixel, bright);
        }
    }
    for (std::uint32_t i = 0; i < pixel.fragments.size(); ++i) pixel.fragments[i].primitive = i;
    return pixel;
}

}  // namespace ropsim
