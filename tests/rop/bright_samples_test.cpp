// bright_samples: Enderton et al. 2011, section 6, "making S higher in pixels where the background is dark":
// here S stays and pixels before a bright background use fewer.
#include "tests/rop/mask_outcomes.h"

namespace ropsim {
namespace {

using test::Estimate;
using test::MaskKind;
using test::TestFrame;

constexpr int kSide = 128;

// Columns left of the middle before black, right of it before white.
TraceHeader half_bright() {
    TraceHeader header = test::header_of(kSide, kSide);
    OpaqueLayer layer;
    for (int i = 0; i < kSide * kSide; ++i) {
        const float grey = i % kSide < kSide / 2 ? 0.0f : 1.0f;
        layer.rgb.insert(layer.rgb.end(), {grey, grey, grey});
        layer.depth.push_back(1);
    }
    header.opaque = layer;
    return header;
}
bool is_bright(std::size_t pixel) {
    return pixel % kSide >= kSide / 2;
}

std::vector<test::Layer> two_layers() {
    return {{0.45, {1, 0, 0}}, {0.3, {0, 1, 0}}};
}

// Dark pixels are those of S samples, bit for bit; bright ones have the moments of bright_samples.
TEST(BrightSamples, DarkPixelsKeepAllAndBrightOnesHaveFewer) {
    const TraceHeader header = half_bright();
    const auto fragments = test::everywhere(header, test::fragments_of(two_layers()));
    for (const Estimate e : {Estimate::kBasic, Estimate::kBasicCorrected, Estimate::kDepthAccumulated})
        for (const MaskKind kind : {MaskKind::kChoose, MaskKind::kCoin}) {
            const std::string technique = test::technique_of(e, kind, 8);
            SCOPED_TRACE(technique);
            const auto all = test::image_of(technique, header, fragments);
            const auto few = test::image_of(technique + ",bright_samples=4", header, fragments);
            std::vector<float> bright;
            for (std::size_t p = 0; p < all.size() / 3; ++p)
                for (std::size_t c = 0; c < 3; ++c) {
                    if (is_bright(p))
                        bright.push_back(few[3 * p + c]);
                    else
                        ASSERT_EQ(few[3 * p + c], all[3 * p + c]);
                }
            // Masks are of 8 samples or of 4, as many as the pixel uses.
            const auto exact = test::exact_moments(e, kind, two_layers(), 4, {1, 1, 1});
            for (std::size_t c = 0; c < 3; ++c) test::expect_moments(bright, c, exact[c]);
        }
}

// Fewer bytes where it is bright: only the first samples are read and written, and resolved.
TEST(BrightSamples, OnlyTheFirstSamplesAreTouched) {
    const TraceHeader header = half_bright();
    const auto fragments = test::everywhere(header, test::fragments_of(two_layers()));
    struct Bytes {
        std::uint64_t dark = 0, bright = 0;
    };
    const auto bytes = [&](const std::string& technique, std::uint64_t bright_mask) {
        TestFrame frame(technique, header, 3);
        frame.draw(fragments);
        Bytes sum;
        for (std::size_t i = 0; i < frame.log().records(); ++i) {
            const bool bright = is_bright(i % (std::size_t{kSide} * kSide));
            for (std::size_t s = 0; s < 2; ++s) {
                const SurfaceAccess& access = frame.log().record_access(i)[s];
                EXPECT_EQ((access.read | access.write) & ~(bright ? bright_mask : 0xFFull), 0u);
                (bright ? sum.bright : sum.dark) +=
                    static_cast<std::uint64_t>(std::popcount(access.read) + std::popcount(access.write));
            }
        }
        return sum;
    };
    const Bytes all = bytes("stochastic:samples=8", 0xFF);
    const Bytes few = bytes("stochastic:samples=8,bright_samples=2", 0b11);
    EXPECT_EQ(few.dark, all.dark);
    EXPECT_LT(few.bright, all.bright / 2);
    EXPECT_NEAR(static_cast<double>(all.bright), static_cast<double>(all.dark),
                0.05 * static_cast<double>(all.dark));
}

// Luminance by Rec. 709 against dark_below, which itself is bright.
TEST(BrightSamples, LuminanceDecides) {
    const auto operation =
        TestFrame::make("stochastic:samples=8,bright_samples=2,dark_below=0.5", test::header_of(1, 1));
    const auto samples_of = [&](glm::vec3 background) {
        return operation->pixel_constant()(0, 0, background);
    };
    EXPECT_EQ(samples_of({0.49f, 0.49f, 0.49f}), 8u);
    EXPECT_EQ(samples_of({0.51f, 0.51f, 0.51f}), 2u);
    EXPECT_EQ(samples_of({0, 1, 0}), 2u) << "green: .7152";
    EXPECT_EQ(samples_of({1, 0, 1}), 8u) << "red and blue: .2848";
    EXPECT_EQ(samples_of({0, 0, 6}), 8u) << ".4332";
    EXPECT_EQ(samples_of({0, 0, 7}), 2u) << ".5054";
}

// What the paper gives as its reason: light layers before dark vary most. With half the samples before
// bright, the error there is still below that before dark.
TEST(BrightSamples, ErrorStaysBelowThatBeforeDark) {
    const std::vector<test::Layer> light = {{0.3, {1, 1, 1}}, {0.3, {0.9, 0.9, 0.9}}};
    const TraceHeader header = half_bright();
    const auto image = test::image_of("stochastic:format=float32,samples=8,bright_samples=4", header,
                                      test::everywhere(header, test::fragments_of(light)));
    double dark = 0;
    double bright = 0;
    for (std::size_t p = 0; p < image.size() / 3; ++p) {
        const double grey = is_bright(p) ? 1 : 0;
        (is_bright(p) ? bright : dark) +=
            std::pow(image[3 * p] - test::blended(light, {grey, grey, grey})[0], 2);
    }
    EXPECT_LT(bright, dark);
}

}  // namespace
}  // namespace ropsim
