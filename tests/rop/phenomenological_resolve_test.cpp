// The background as phenomenological transparency displaces and blurs it, against double precision, over
// render targets filled by hand: McGuire and Mara 2017, sections 5.0.2 and 5.0.3 and Listing 3.
#include "tests/rop/phenomenological_scene.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::fill;
using test::pixel_of;
using test::Random;
using test::TargetField;
using test::Targets;
using test::TestFrame;

// The technique with these keys besides.
std::string with_keys(const std::string& keys = "") {
    return "phenomenological:format=float32" + keys;
}

void add_scaled(std::array<double, 3>& sum, double w, const std::array<double, 3>& value) {
    for (std::size_t c = 0; c < 3; ++c) sum[c] += w * value[c];
}

TEST(PhenomenologicalResolve, DisplacedBackgroundIsBilinear) {
    Random random(11);
    TargetField field(21, 13, random);
    for (Targets& t : field.targets) {
        t.x = random.real(-0.4, 0.4);  // up to 25 pixels: past every border
        t.y = random.real(-0.4, 0.4);
    }
    field.targets[5].x = 300;  // beyond what a target of 8 bits holds
    const std::vector<float> image = field.resolved(with_keys());
    for (int y = 0; y < field.height; ++y) {
        for (int x = 0; x < field.width; ++x) {
            const double u = x + 63.0 * field.at(x, y).x, v = y + 63.0 * field.at(x, y).y;
            const int left = static_cast<int>(std::floor(u)), top = static_cast<int>(std::floor(v));
            std::array<double, 3> sum{};
            for (const int j : {0, 1})
                for (const int i : {0, 1})
                    add_scaled(sum, (1 - std::abs(u - left - i)) * (1 - std::abs(v - top - j)),
                               field.behind(left + i, top + j));
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(pixel_of(image, field.width, x, y, c), sum[static_cast<std::size_t>(c)], 2e-5)
                    << x << "," << y;
        }
    }
}

struct Filter {
    const char* keys;
    bool gaussian, exact;
    int most;
};

// The kernel as the paper's text and Listing 3 have it: a tap counts where its own D reaches back to the
// middle, and weighs less the wider it is blurred.
std::array<double, 3> filtered(const TargetField& field, const Filter& filter, int x, int y) {
    const int stride = filter.exact ? 1 : 2;
    const auto variance = [&](int u, int v) { return 63.0 * 63.0 * field.at(u, v).diffusion; };
    const double own = variance(x, y);
    const double reach = filter.exact && filter.gaussian ? 3 : 1;
    const int cx = std::clamp(x + static_cast<int>(63 * field.at(x, y).x), 0, field.width - 1);
    const int cy = std::clamp(y + static_cast<int>(63 * field.at(x, y).y), 0, field.height - 1);
    const int most = filter.most / stride * stride;
    std::array<double, 3> sum{};
    double weights = 0;
    for (int v = -most; v <= most; v += stride) {
        for (int u = -most; u <= most; u += stride) {
            const double distance = std::hypot(u, v);
            const double there = std::max(variance(cx + u, cy + v), 0.25);
            if (distance > reach * std::sqrt(own)) continue;
            if (distance > reach * std::sqrt(variance(cx + u, cy + v))) continue;
            double w = 1 / there + 1e-5;
            if (filter.gaussian && filter.exact) w = std::exp(-distance * distance / (2 * there)) / there;
            if (filter.gaussian && !filter.exact)
                w = std::exp(-distance * distance / (8 * there)) / std::sqrt(there);
            add_scaled(sum, w, field.behind(cx + u, cy + v));
            weights += w;
        }
    }
    for (double& s : sum) s /= weights;
    return sum;
}

class PhenomenologicalDiffusion : public testing::TestWithParam<Filter> {};
INSTANTIATE_TEST_SUITE_P(Filters, PhenomenologicalDiffusion,
                         testing::Values(Filter{"", false, false, 16},
                                         Filter{",gather=exact", false, true, 16},
                                         Filter{",filter=gaussian", true, false, 16},
                                         Filter{",filter=gaussian,gather=exact", true, true, 16},
                                         Filter{",filter=gaussian,gather=exact,max_radius=7", true, true, 7},
                                         Filter{",max_radius=5", false, false, 5}),
                         [](const auto& test) {
                             return std::string(test.param.gaussian ? "gaussian" : "disk") +
                                    (test.param.exact ? "_exact" : "") + "_" +
                                    std::to_string(test.param.most);
                         });

// A third of the pixels does not diffuse, some of the others lead there.
TEST_P(PhenomenologicalDiffusion, EqualsTheKernelInDouble) {
    Random random(12);
    TargetField field(37, 29, random);
    for (Targets& t : field.targets) {
        // Not on the boundary of a disk: D^2 is an integer and a half.
        const double variance = random.integer(0, 350) + 0.5;
        t.diffusion = random.integer(0, 2) == 0 ? 0 : static_cast<float>(variance / (63 * 63));
        t.x = (static_cast<float>(random.integer(-9, 9)) + 0.25f) / 63;
        t.y = (static_cast<float>(random.integer(-9, 9)) + 0.25f) / 63;
    }
    const std::vector<float> image = field.resolved(with_keys(GetParam().keys));
    int nowhere = 0;
    for (int y = 0; y < field.height; ++y) {
        for (int x = 0; x < field.width; ++x) {
            const Targets& t = field.at(x, y);
            if (t.diffusion == 0) continue;
            nowhere +=
                field.at(x + static_cast<int>(63 * t.x), y + static_cast<int>(63 * t.y)).diffusion == 0;
            const auto exact = filtered(field, GetParam(), x, y);
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(pixel_of(image, field.width, x, y, c), exact[static_cast<std::size_t>(c)], 1e-5)
                    << x << "," << y;
        }
    }
    EXPECT_GT(nowhere, 100);
}

// Normalised by what it has gathered: a background of one colour stays, as far as a quotient of sums does.
TEST_P(PhenomenologicalDiffusion, KeepsAUniformBackground) {
    Random random(13);
    TargetField field(33, 20, random);
    field.header = test::pictured(33, 20, 0.75f, [](int, int) -> std::array<float, 3> {
        return {0.5f, 0.3f, 4.0f};
    });
    for (Targets& t : field.targets) {
        t.diffusion = random.real(0, 0.2);
        t.x = random.real(-0.5, 0.5);
    }
    const std::vector<float> image = field.resolved(with_keys(GetParam().keys));
    for (std::size_t i = 0; i < image.size(); i += 3) {
        // A power of two scales every term and sum without rounding.
        ASSERT_EQ(image[i], 0.5f);
        ASSERT_NEAR(image[i + 1], 0.3f, 2e-6);
        ASSERT_EQ(image[i + 2], 4.0f);
    }
}

// A bright pixel behind a uniform D, which is the filter's point spread.
std::vector<float> spread(const std::string& keys, int size, double deviation) {
    TestFrame frame(with_keys(keys), test::single_bright_pixel(size, size / 2, size / 2));
    Targets t;
    t.diffusion = static_cast<float>(deviation * deviation / (63 * 63));
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) fill(frame, x, y, t);
    return frame.image();
}

// Of a Gaussian cut off at r deviations the variance an axis keeps 1 - u / (e^u - 1), u = r^2 / 2.
TEST(PhenomenologicalDiffusionWidth, IsDOfTheGaussianAndHalfOfItOfTheListing) {
    constexpr int kSize = 61;
    const auto cut = [](double r) { return 1 - r * r / 2 / std::expm1(r * r / 2); };
    for (const double d : {2.0, 3.0, 5.0}) {
        const auto image = spread(",filter=gaussian,gather=exact", kSize, d * 1.0001);
        EXPECT_NEAR(test::variance_along_x(image, kSize, kSize / 2) / (d * d), cut(3), 0.02) << d;  // .949
    }
    // The text says that D is the deviation; the listing's disk ends there, a quarter of the variance: what
    // it shows is half as blurred. Its Gaussian of 2 D cut off at D hardly differs, .245.
    EXPECT_NEAR(4 * cut(0.5), 0.245, 5e-4);
    for (const double d : {10.0, 16.0}) {
        const auto disk = spread("", kSize, d * 1.0001);
        EXPECT_NEAR(test::variance_along_x(disk, kSize, kSize / 2) / (d * d), 0.25, 0.01) << d;
        const auto gaussian = spread(",filter=gaussian", kSize, d * 1.0001);
        EXPECT_NEAR(test::variance_along_x(gaussian, kSize, kSize / 2) / (d * d), 4 * cut(0.5), 0.01) << d;
    }
    // Of 63 pixels, the most that is stored, 16 show: a square then, of variance (16^2 + 2 * 16) / 3.
    const auto capped = spread("", kSize, 63);
    EXPECT_NEAR(test::variance_along_x(capped, kSize, kSize / 2), (16 * 16 + 2 * 16) / 3.0, 1e-3);
}

// Surfaces that scatter a thousand metres wide fill a float16 with variance; no tap may weigh nothing then.
TEST(PhenomenologicalDiffusion, ThatOverflowsStillHasAColour) {
    const TraceHeader header = test::with_materials(test::header_of(9, 9, 1, {0.5f, 0.25f, 1}));
    for (const char* keys : {"filter=gaussian", "filter=gaussian,gather=exact", "filter=disk"}) {
        TestFrame frame(std::string("phenomenological:beta_format=float16,k0=1000,") + keys, header);
        std::vector<Fragment> fragments;
        for (int i = 0; i < 81; ++i)
            for (int n = 0; n < 3; ++n)
                fragments.push_back(test::fragment_at(i % 9, i / 9, 0.1f, 0.5f, {0.5f, 0.5f, 0.5f}));
        frame.draw(fragments, {},
                   std::vector<Material>(fragments.size(), test::material_of({0.5f, 0.5f, 0.5f}, 0)));
        for (const float value : frame.image()) ASSERT_TRUE(std::isfinite(value)) << keys;
    }
}

}  // namespace
}  // namespace ropsim
