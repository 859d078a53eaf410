// Moments and wavelets against the exact image where the setting is known in full: 12 layers of alpha 0.3 at
// random depths, in random colours.
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// RMS over the pixels of an image, in 1/255.
double rms_of_layers(const std::string& technique) {
    constexpr int kSide = 48;
    constexpr int kLayers = 12;
    Random random(1);
    const TraceHeader header = test::header_of(kSide, kSide, 1, {0, 0, 0});
    std::vector<Fragment> fragments;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            for (int i = 0; i < kLayers; ++i)
                fragments.push_back(
                    test::fragment_at(x, y, random.real(0, 1), 0.3f,
                                      {random.real(0, 1), random.real(0, 1), random.real(0, 1)}));
    TestFrame frame(technique, header, 0, 1, false);
    frame.draw(fragments);
    const std::vector<float> image = frame.image();
    double sum = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
        const auto own = std::span(fragments).subspan(static_cast<std::size_t>(i) * kLayers, kLayers);
        const auto exact = test::composited(own, i % kSide, i / kSide, {0, 0, 0});
        for (std::size_t c = 0; c < 3; ++c)
            sum += std::pow(255 * (image[static_cast<std::size_t>(3 * i) + c] - exact[c]), 2);
    }
    return std::sqrt(sum / (3 * kSide * kSide));
}

// Two numbers of the setting's description are not known, the number of pixels and the moments'
// overestimation. Wavelets come out as noted elsewhere (7.6, 5.0, 3.5); for 4 power, 8 power and 4
// trigonometric moments 9.3, 6.9 and 5.6 were noted, which no one overestimation gives (0.15: 9.1, 5.5, 6.3;
// 0: 11.5, 7.0, 7.1).
TEST(MomentsAndWavelets, TwelveLayersAtRandomDepths) {
    const auto expect = [](const std::string& technique, double rms) {
        // The spread over seeds of 2,304 pixels is 2%.
        EXPECT_NEAR(rms_of_layers(technique), rms, 0.06 * rms) << technique;
    };
    expect("wavelet:rank=1", 7.48);
    expect("wavelet:rank=2", 5.00);
    expect("wavelet:rank=3", 3.52);
    expect("wavelet:rank=4", 2.49);
    expect("moment_based", 7.62);
    expect("moment_based:moments=6", 5.75);
    expect("moment_based:moments=8", 4.65);
    expect("moment_based:basis=trigonometric", 10.02);
    expect("moment_based:basis=trigonometric,moments=6", 7.58);
    expect("moment_based:basis=trigonometric,moments=8", 5.88);
    expect("moment_based:overestimation=0", 11.53);
    expect("moment_based:overestimation=0,moments=8", 7.04);
    expect("moment_based:overestimation=.15", 9.15);
    expect("adaptive:nodes=8", 6.24);
}

}  // namespace
}  // namespace ropsim
