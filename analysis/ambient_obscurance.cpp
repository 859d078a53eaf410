#include "analysis/ambient_obscurance.h"

#include "base/parallel.h"
#include "rop/transcendental.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ropsim {

namespace {

constexpr double kEpsilon = 0.01;  // square metres, the authors': keeps cracks from going black
constexpr double kGoldenTurns = 0.38196601125010515;

class ObscurancePass {
 public:
    ObscurancePass(const DepthBuffer& depth, const AmbientView& view, const ObscuranceSettings& settings)
        : depth_(depth), view_(view), settings_(settings) {
        const double taps = settings.taps;
        for (int k = 0; k < settings.taps; ++k) {
            const SineCosine turned = deterministic_sine_cosine(k * kGoldenTurns);
            pattern_.push_back((k + 0.5) / taps * glm::dvec2(turned.cosine, turned.sine));
        }
        const double square = settings.radius * settings.radius;
        scale_ = 5 * settings.intensity / (taps * square * square * square);
    }

    // A, and the fetches it took are added to `fetches`.
    double at(int x, int y, std::uint64_t& fetches) const {
        const glm::dvec3 here = view_.at_pixel(x, y, depth_.depth[depth_.index(x, y)]);
        const std::optional<glm::dvec3> right = step(here, x, y, 1, 0, fetches);
        const std::optional<glm::dvec3> down = step(here, x, y, 0, 1, fetches);
        if (!right || !down) return 1;
        // Image rows run down, camera space up: this product points at the eye.
        const glm::dvec3 across = glm::cross(*down, *right);
        const double length = std::sqrt(glm::dot(across, across));
        if (!(length > 0)) return 1;
        const glm::dvec3 normal = across / length;
        const glm::dvec2 disc = settings_.radius * view_.pixels_per_metre(here);
        const SineCosine spin = deterministic_sine_cosine(turns(x, y));
        double sum = 0;
        for (const glm::dvec2& tap : pattern_) {
            const double u = (tap.x * spin.cosine - tap.y * spin.sine) * disc.x;
            const double v = (tap.x * spin.sine + tap.y * spin.cosine) * disc.y;
            sum += occlusion(here, normal, x + 0.5 + u, y + 0.5 + v, fetches);
        }
        return std::max(0.0, 1 - scale_ * sum);
    }

 private:
    // The authors' (3 x ^ y + x y) * 10 radians.
    static double turns(int x, int y) {
        const auto column = static_cast<std::uint32_t>(x);
        const auto row = static_cast<std::uint32_t>(y);
        return ((3 * column) ^ (row + column * row)) * (10 / 6.283185307179586);
    }
    bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < depth_.width && y < depth_.height; }

    // Along an axis to a neighbouring texel's point, in the axis' direction; the neighbour nearer in z, of
    // equals the further along. None where nothing was drawn on either side.
    std::optional<glm::dvec3> step(const glm::dvec3& here, int x, int y, int dx, int dy,
                                   std::uint64_t& fetches) const {
        std::optional<glm::dvec3> best;
        for (const int sign : {1, -1}) {
            const int column = x + sign * dx;
            const int row = y + sign * dy;
            if (!inside(column, row)) continue;
            ++fetches;
            if (!depth_.drawn(column, row)) continue;
            const glm::dvec3 there = view_.at_pixel(column, row, depth_.depth[depth_.index(column, row)]);
            const glm::dvec3 along = static_cast<double>(sign) * (there - here);
            if (!best || std::abs(along.z) < std::abs(best->z)) best = along;
        }
        return best;
    }

    double occlusion(const glm::dvec3& here, const glm::dvec3& normal, double at_x, double at_y,
                     std::uint64_t& fetches) const {
        // Far outside the image, where an int could not hold them.
        if (!(std::abs(at_x) < 1e6 && std::abs(at_y) < 1e6)) return 0;
        const int x = static_cast<int>(std::floor(at_x));
        const int y = static_cast<int>(std::floor(at_y));
        if (!inside(x, y)) return 0;
        ++fetches;
        if (!depth_.drawn(x, y)) return 0;
        const glm::dvec3 v = view_.at_pixel(x, y, depth_.depth[depth_.index(x, y)]) - here;
        const double square = glm::dot(v, v);
        const double near = std::max(0.0, settings_.radius * settings_.radius - square);
        const double above = std::max(0.0, (glm::dot(v, normal) - settings_.bias) / (square + kEpsilon));
        return near * near * near * above;
    }

    const DepthBuffer& depth_;
    const AmbientView& view_;
    const ObscuranceSettings& settings_;
    std::vector<glm::dvec2> pattern_;  // in the unit disc
    double scale_ = 0;
};

}  // namespace

Obscurance ambient_obscurance(const DepthBuffer& depth, const AmbientView& view,
                              const ObscuranceSettings& settings, int threads) {
    const ObscurancePass pass(depth, view, settings);
    Obscurance result;
    result.ambient.assign(depth.depth.size(), 1.0f);
    const auto rows = static_cast<std::size_t>(depth.height);
    std::vector<std::uint64_t> pixels(rows), fetches(rows);
    parallel_for(threads, depth.height, [&](int y) {
        const auto row = static_cast<std::size_t>(y);
        fetches[row] = static_cast<std::uint64_t>(depth.width);
        for (int x = 0; x < depth.width; ++x) {
            if (!depth.drawn(x, y)) continue;
            ++pixels[row];
            result.ambient[depth.index(x, y)] =
                stored_value(settings.format, static_cast<float>(pass.at(x, y, fetches[row])));
        }
    });
    for (std::size_t row = 0; row < rows; ++row) {
        result.pixels += pixels[row];
        result.fetches += fetches[row];
    }
    return result;
}

}  // namespace ropsim
