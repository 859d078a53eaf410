// Ambient occlusion in screen space against surfaces whose obscurance an integral gives.
#include "analysis/ambient_obscurance.h"

#include "tests/analysis/ambient_view_of.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr double kTurn = 6.283185307179586;

ObscuranceSettings float_settings(int taps = 32) {
    ObscuranceSettings settings;
    settings.format = Format::kFloat32;
    settings.taps = taps;
    return settings;
}

// What one tap adds in a right-angled valley with its floor along y and sides of 45 degrees: the heights are
// |x|. From a point at x0 > 0 only x < 0 rises above the side's plane, by sqrt(2) |x|.
double valley_tap(double x0, double x, double y, const ObscuranceSettings& s) {
    if (x >= 0) return 0;
    const double square = (x - x0) * (x - x0) + y * y + (x + x0) * (x + x0);
    const double near = std::max(0.0, s.radius * s.radius - square);
    return near * near * near * std::max(0.0, (-std::sqrt(2.0) * x - s.bias) / (square + 0.01));
}

// Mean over all turns of the pattern of A without its lower bound; `snap` moves a tap to where it is read.
double valley(double x0, const ObscuranceSettings& s, const std::function<double(double)>& snap) {
    constexpr int kAngles = 2048;
    double sum = 0;
    for (int k = 0; k < s.taps; ++k) {
        for (int i = 0; i < kAngles; ++i) {
            const double r = s.radius * (k + 0.5) / s.taps;
            const double angle = kTurn * (i + 0.5) / kAngles;
            sum += valley_tap(x0, snap(x0 + r * std::cos(angle)), snap(0.5 + r * std::sin(angle)) - 0.5, s);
        }
    }
    return 1 - 5 * s.intensity / (std::pow(s.radius, 6) * s.taps) * sum / kAngles;
}

struct Sampled {
    double mean = 0;
    double standard_error = 0;
};

// A in the column of a valley that holds x0, over the rows that see their whole disc.
class Valley {
 public:
    Valley(double pixel, const ObscuranceSettings& settings)
        : pixel_(pixel), width_(static_cast<int>(4 / pixel)), height_(static_cast<int>(8 / pixel)) {
        const DepthBuffer depth =
            heights(width_, height_, 4, 8, [](double x, double) { return std::abs(x); });
        const AmbientView view(header_of(width_, height_, from_above(4, 8)), "valley");
        ambient_ = ambient_obscurance(depth, view, settings, 2).ambient;
    }
    int column(double x0) const { return static_cast<int>((x0 + 2) / pixel_); }
    double centre(int column) const { return (column + 0.5) * pixel_ - 2; }
    Sampled at(int column) const {
        const int margin = static_cast<int>(0.8 / pixel_);
        double sum = 0, squares = 0;
        const double rows = height_ - 2 * margin;
        for (int row = margin; row < height_ - margin; ++row) {
            const double a = static_cast<double>(ambient_[static_cast<std::size_t>(row * width_ + column)]);
            sum += a;
            squares += a * a;
        }
        const double mean = sum / rows;
        return {mean, std::sqrt(std::max(0.0, squares / rows - mean * mean) / rows)};
    }

 private:
    double pixel_;
    int width_, height_;
    std::vector<float> ambient_;
};

TEST(AmbientObscuranceTest, APlaneIsUnoccluded) {
    const DepthBuffer tilted = heights(64, 48, 4, 3, [](double x, double y) { return 0.7 * x - 1.3 * y; });
    const AmbientView straight(header_of(64, 48, from_above(4, 3)), "plane");
    for (const float a : ambient_obscurance(tilted, straight, float_settings(), 1).ambient)
        EXPECT_EQ(a, 1.0f);
    // In perspective: 1 / (distance along z) is linear in the image, and so is window depth.
    DepthBuffer floor{64, 48, {}};
    for (int row = 0; row < 48; ++row)
        for (int column = 0; column < 64; ++column)
            floor.depth.push_back(static_cast<float>(0.99 - 0.01 * row + 0.002 * column));
    const AmbientView eye(header_of(64, 48, glm::perspective(1.0f, 4.0f / 3, 0.1f, 100.0f)), "plane");
    for (const float a : ambient_obscurance(floor, eye, float_settings(), 1).ambient) EXPECT_EQ(a, 1.0f);
}

TEST(AmbientObscuranceTest, AValleyHasTheObscuranceOfItsIntegral) {
    ObscuranceSettings settings = float_settings();
    settings.intensity = 0.5;  // at 1 the crease reaches the lower bound
    const double pixel = 0.02;
    const Valley image(pixel, settings);
    const auto snap = [&](double at) { return (std::floor(at / pixel) + 0.5) * pixel; };
    double before = 0;
    for (const double x0 : {0.05, 0.11, 0.21, 0.35, 0.45}) {
        const int column = image.column(x0);
        const Sampled sampled = image.at(column);
        const double expected = valley(image.centre(column), settings, snap);
        EXPECT_NEAR(sampled.mean, expected, 4 * sampled.standard_error + 1e-6) << x0;
        EXPECT_GT(sampled.mean, before) << "occlusion grows towards the crease, at " << x0;
        before = sampled.mean;
    }
    EXPECT_LT(image.at(image.column(0.05)).mean, 0.5);
    // The other side is further than the radius away.
    EXPECT_EQ(image.at(image.column(settings.radius / std::sqrt(2.0) + 2 * pixel)).mean, 1.0);
}

TEST(AmbientObscuranceTest, ResolutionDoesNotMatter) {
    const ObscuranceSettings settings = float_settings();
    const auto exactly = [](double at) { return at; };
    for (const double pixel : {0.04, 0.02, 0.01}) {
        const Valley image(pixel, settings);
        const auto snap = [&](double at) { return (std::floor(at / pixel) + 0.5) * pixel; };
        for (const double x0 : {0.1, 0.3}) {
            const int column = image.column(x0);
            const double centre = image.centre(column);
            const Sampled sampled = image.at(column);
            // What reading whole pixels alone changes, and the noise of the pattern's turns.
            const double limit = valley(centre, settings, exactly);
            const double snapping = std::abs(valley(centre, settings, snap) - limit);
            EXPECT_NEAR(sampled.mean, limit, snapping + 4 * sampled.standard_error) << pixel << ' ' << x0;
            EXPECT_LT(snapping, 0.6 * pixel);
        }
    }
}

TEST(AmbientObscuranceTest, LengthsAreMetres) {
    const auto bumps = [](double x, double y) { return 0.3 * std::sin(5 * x) * std::cos(4 * y); };
    const AmbientView metres(header_of(80, 60, from_above(4, 3)), "metres");
    const Obscurance expected = ambient_obscurance(heights(80, 60, 4, 3, bumps), metres, float_settings(), 1);
    // The same surface in a scene of half metres: 8 x 6 units, seen from 10 above.
    const AmbientView halves(header_of(80, 60, glm::ortho(-4.0f, 4.0f, -3.0f, 3.0f, 0.0f, 20.0f), 0.5f),
                             "half metres");
    const Obscurance half = ambient_obscurance(heights(80, 60, 4, 3, bumps), halves, float_settings(), 1);
    double least = 1;
    for (std::size_t i = 0; i < expected.ambient.size(); ++i) {
        EXPECT_NEAR(half.ambient[i], expected.ambient[i], 1e-5);
        least = std::min(least, static_cast<double>(expected.ambient[i]));
    }
    EXPECT_LT(least, 0.7);
}

TEST(AmbientObscuranceTest, FetchesAreCounted) {
    // A disc of 0.1 m is 2 pixels wide: 30 x 20 pixels read 1 + 4 + 7 texels, less what lies outside.
    ObscuranceSettings settings = float_settings(7);
    settings.radius = 0.1;
    const AmbientView view(header_of(40, 30, from_above(2, 1.5f)), "flat");
    DepthBuffer depth = heights(40, 30, 2, 1.5, [](double, double) { return 0.0; });
    const Obscurance flat = ambient_obscurance(depth, view, settings, 1);
    EXPECT_EQ(flat.pixels, 40u * 30u);
    EXPECT_LE(flat.fetches, 40u * 30u * (1 + 4 + 7));
    EXPECT_GE(flat.fetches, 36u * 26u * (1 + 4 + 7));
    // Nothing drawn: each pixel finds that out by its own texel.
    std::fill(depth.depth.begin(), depth.depth.end(), std::numeric_limits<float>::infinity());
    const Obscurance empty = ambient_obscurance(depth, view, settings, 1);
    EXPECT_EQ(empty.pixels, 0u);
    EXPECT_EQ(empty.fetches, 40u * 30u);
    // One pixel in the middle: its own, 4 neighbours, and no normal without them.
    depth.depth[depth.index(20, 15)] = 0.5f;
    const Obscurance one = ambient_obscurance(depth, view, settings, 1);
    EXPECT_EQ(one.fetches, 40u * 30u + 4u);
    EXPECT_EQ(one.ambient[depth.index(20, 15)], 1.0f);
    // Two by two have normals, and 7 taps each.
    for (const auto& [x, y] : {std::pair(21, 15), {20, 16}, {21, 16}}) depth.depth[depth.index(x, y)] = 0.5f;
    EXPECT_EQ(ambient_obscurance(depth, view, settings, 1).fetches, 40u * 30u + 4u * (4u + 7u));
}

TEST(AmbientObscuranceTest, ThreadsAndFormatsDoNotMatterButForRounding) {
    const auto ridge = [](double x, double y) { return std::abs(std::sin(3 * x + y)); };
    const DepthBuffer depth = heights(80, 60, 4, 3, ridge);
    const AmbientView view(header_of(80, 60, from_above(4, 3)), "ridges");
    const Obscurance one = ambient_obscurance(depth, view, float_settings(), 1);
    const Obscurance four = ambient_obscurance(depth, view, float_settings(), 4);
    EXPECT_EQ(one.ambient, four.ambient);
    EXPECT_EQ(one.fetches, four.fetches);
    ObscuranceSettings bytes = float_settings();
    bytes.format = Format::kUnorm8;
    const Obscurance stored = ambient_obscurance(depth, view, bytes, 1);
    for (std::size_t i = 0; i < one.ambient.size(); ++i)
        EXPECT_NEAR(stored.ambient[i], one.ambient[i], 0.5 / 255 + 1e-6);
}

}  // namespace
}  // namespace ropsim
