// The second geometry pass of stochastic layered alpha blending, where nothing is random (bits=inf): D of
// Enderton et al. 2011, section 4.2, over the list's visibility, and the same without its correction.
#include "tests/rop/worst_case_bytes.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

struct Sums {
    std::array<double, 3> u{};
    double u1 = 0;
    double clear = 1;  // of all fragments
    double list = 1;   // of the list's
};

// By the definition: the list is the n nearest, visibility the product over those strictly in front.
Sums sums_of(std::span<const Fragment> fragments, int x, int y, std::size_t layers) {
    const auto own = test::nearest_first(fragments, x, y);
    Sums s;
    for (const Fragment& f : own) {
        double seen = 1;
        for (std::size_t i = 0; i < std::min(layers, own.size()); ++i)
            if (own[i].z < f.z) seen *= 1.0 - static_cast<double>(own[i].a);
        s.u = {s.u[0] + seen * f.r, s.u[1] + seen * f.g, s.u[2] + seen * f.b};
        s.u1 += seen * f.a;
        s.clear *= 1.0 - static_cast<double>(f.a);
    }
    for (std::size_t i = 0; i < std::min(layers, own.size()); ++i)
        s.list *= 1.0 - static_cast<double>(own[i].a);
    return s;
}

// Ties and alphas of 0 and 1 included.
TEST(SlabNormalised, EqualsItsDefinition) {
    Random random(71);
    const TraceHeader header = test::opaque_header(9, 6, 1, random);
    const auto fragments = test::random_fragments(header, {.count = 1200}, random);
    for (const bool normalised : {true, false}) {
        for (const int layers : {1, 4, 8}) {
            TestFrame frame(fmt::format("slab:layers={},bits=inf,format=float32,composite={}", layers,
                                        normalised ? "normalised" : "accumulated"),
                            header);
            frame.draw(fragments);
            const auto image = frame.image();
            for (int pixel = 0; pixel < header.width * header.height; ++pixel) {
                const int x = pixel % header.width;
                const int y = pixel / header.width;
                const Sums s = sums_of(fragments, x, y, static_cast<std::size_t>(layers));
                const auto background = test::background_of(header, x, y);
                for (std::size_t c = 0; c < 3; ++c) {
                    const double expected =
                        normalised ? (1 - s.clear) * (s.u1 > 0 ? s.u[c] / s.u1 : 0) + s.clear * background[c]
                                   : s.u[c] + s.list * background[c];
                    ASSERT_NEAR(image[static_cast<std::size_t>(3 * pixel) + c], expected, 2e-5)
                        << x << "," << y << " " << layers;
                }
            }
        }
    }
}

// The background is exact however many fragments the list has lost: their alphas all count.
TEST(SlabNormalised, BackgroundIsExact) {
    for (const char* coverage : {"continuous", "discrete"}) {
        TestFrame frame(
            fmt::format("slab:layers=2,bits=4,format=float32,composite=normalised,coverage={}", coverage),
            test::header_of(8, 8, 1, {0, 0, 1}));
        Random random(5);
        std::vector<Fragment> fragments;
        double clear = 1;
        for (std::uint32_t l = 0; l < 30; ++l) {
            const float alpha = random.real(0.02, 0.1);
            clear *= 1.0 - static_cast<double>(alpha);
            for (int i = 0; i < 64; ++i)
                fragments.push_back(test::fragment_at(i % 8, i / 8, random.real(0, 1), alpha, {1, 0, 0}, l));
        }
        frame.draw(fragments);
        for (int i = 0; i < 64; ++i) {
            const auto color = frame.color(i % 8, i / 8);
            EXPECT_NEAR(color[2], clear, 1e-5);
            EXPECT_NEAR(color[0], 1 - clear, 1e-5) << "of one colour, the normalisation gives all of it";
        }
    }
}

// A fragment of no bit is never inserted. Straight from the layers it is lost; the second pass has it.
TEST(SlabNormalised, FragmentsBelowHalfABit) {
    const Fragment thin = test::fragment_at(0, 0, 0.5f, 0.03f, {1, 1, 1});
    for (const char* composite : {"direct", "accumulated", "normalised"}) {
        TestFrame frame(fmt::format("slab:layers=8,bits=16,format=float32,composite={}", composite),
                        test::header_of(1, 1, 1, {0, 0, 0}));
        frame.draw_one(thin);
        EXPECT_EQ(frame.log().path_count(static_cast<std::size_t>(frame.declaration().path("empty_mask"))),
                  1u);
        EXPECT_NEAR(frame.color()[0], composite == std::string("direct") ? 0.0f : 0.03f, 1e-7);
    }
}

// Behind an opaque layer nothing is inserted, whatever the bits, and nothing accumulated.
TEST(SlabNormalised, NothingBehindAnOpaqueLayer) {
    for (const char* bits : {"bits=4", "bits=1024", "bits=64,coverage=discrete"}) {
        TestFrame frame(fmt::format("slab:layers=4,format=float32,composite=normalised,{}", bits),
                        test::header_of(1, 1, 1, {0, 0, 1}));
        frame.draw({{test::fragment_at(0, 0, 0.25f, 1.0f, {1, 0, 0}, 0),
                     test::fragment_at(0, 0, 0.5f, 0.5f, {0, 1, 0}, 1)}});
        EXPECT_EQ(frame.color(), (std::array<float, 3>{1, 0, 0})) << bits;
        EXPECT_EQ(frame.log().path_count(static_cast<std::size_t>(frame.declaration().path("discard"))), 1u);
        EXPECT_EQ(frame.log().path_count(static_cast<std::size_t>(frame.declaration().path("unseen"))), 1u);
    }
}

// Coplanar layers. In the list the earlier arrival is in front: "over" gives 0.75 of two halves. The second
// pass looks strictly in front, so both are seen whole, and the normalisation brings the sum of 1 back to
// 0.75.
TEST(SlabNormalised, CoplanarPair) {
    const std::vector<Fragment> pair = {test::fragment_at(0, 0, 0.5f, 0.5f, {1, 0, 0}, 0),
                                        test::fragment_at(0, 0, 0.5f, 0.5f, {0, 1, 0}, 1)};
    const auto color = [&](const std::string& composite) {
        TestFrame frame("slab:layers=4,bits=inf,format=float32,composite=" + composite,
                        test::header_of(1, 1, 1, {0, 0, 0}));
        frame.draw(pair);
        return frame.color();
    };
    EXPECT_EQ(color("direct"), (std::array<float, 3>{0.5f, 0.25f, 0}));
    EXPECT_EQ(color("accumulated"), (std::array<float, 3>{0.5f, 0.5f, 0}));
    EXPECT_EQ(color("normalised"), (std::array<float, 3>{0.375f, 0.375f, 0}));
}

}  // namespace
}  // namespace ropsim
