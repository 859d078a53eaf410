// Alpha blending of fragments that arrive sorted: exact for each spatial sample, and the mean of them.
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

constexpr int kSide = 8;

TEST(AlphaBlend, BackToFrontIsExactForEachSample) {
    for (const int samples : {1, 2, 4, 8, 16}) {
        Random random(static_cast<std::uint64_t>(samples));
        const TraceHeader header = test::opaque_header(kSide, kSide, samples, random);
        test::FragmentOptions options;
        options.count = std::size_t{8} * kSide * kSide;
        options.distinct_depths = true;
        auto fragments = test::random_fragments(header, options, random);
        std::vector<std::size_t> order(fragments.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::ranges::sort(order,
                          [&](std::size_t a, std::size_t b) { return fragments[a].z > fragments[b].z; });
        std::vector<Fragment> sorted;
        for (const std::size_t i : order) sorted.push_back(fragments[i]);
        TestFrame frame("alpha_blend:format=float32", header);
        frame.draw(sorted);
        const auto image = frame.image();
        for (int pixel = 0; pixel < kSide * kSide; ++pixel) {
            const int x = pixel % kSide;
            const int y = pixel / kSide;
            std::array<double, 3> exact{};
            for (int m = 0; m < samples; ++m) {
                std::vector<Fragment> own;
                for (const Fragment& f : sorted)
                    if ((f.coverage >> m & 1) != 0) own.push_back(f);
                const auto color = test::composited(own, x, y, test::background_of(header, x, y));
                for (std::size_t c = 0; c < 3; ++c) exact[c] += color[c] / samples;
            }
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(image[static_cast<std::size_t>(3 * pixel) + c], exact[c], 1e-5)
                    << samples << " samples, pixel " << x << " " << y;
        }
    }
}

}  // namespace
}  // namespace ropsim
