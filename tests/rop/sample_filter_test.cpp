// Filters over samples and pixels: Enderton et al. 2011's 2 x 2 Gaussian (section 3.5) against a convolution
// of its own in double precision, and the filter across pixels of similar total alpha (section 6).
#include "tests/rop/pixel_moments.h"
#include "traces/sample_positions.h"

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

constexpr int kWidth = 21;
constexpr int kHeight = 13;

// What a stored sample holds, as the pixel's words have it.
class StoredValues {
 public:
    explicit StoredValues(TestFrame& frame) : frame_(&frame) {}
    // Channel of an element of the surface of this name; a pixel's single element serves all samples.
    double value(const std::string& surface, int x, int y, int sample, int channel) const {
        for (const Surface& s : frame_->declaration().surfaces) {
            if (s.name != surface) continue;
            const int element = s.elements == 1 ? 0 : sample;
            // A fourth channel that is a field of its own lies behind the colours of all elements.
            const int word = channel < s.first_channels
                                 ? s.first_word + element * s.first_channels + channel
                                 : s.first_word + s.elements * s.first_channels + element;
            return std::bit_cast<float>(frame_->words(x, y)[static_cast<std::size_t>(word)]);
        }
        ADD_FAILURE() << "no surface " << surface;
        return 0;
    }

 private:
    TestFrame* frame_;
};

// RenderMan's Gaussian of width 2: exp(-2 r^2) in the square of side 2 around the pixel's centre, normalised.
// value(x, y, sample) for the samples of 3 x 3 pixels, the image's border repeated.
template <class Value>
double gaussian(int spatial, int samples, int x, int y, Value value) {
    double sum = 0;
    double weights = 0;
    const auto positions = sample_positions(spatial);
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            for (int s = 0; s < samples; ++s) {
                const SamplePosition at = positions[static_cast<std::size_t>(s % spatial)];
                const double u = dx + at.x16 / 16.0;
                const double v = dy + at.y16 / 16.0;
                if (std::abs(u) > 1 || std::abs(v) > 1) continue;
                const double weight = std::exp(-2 * (u * u + v * v));
                weights += weight;
                sum +=
                    weight * value(std::clamp(x + dx, 0, kWidth - 1), std::clamp(y + dy, 0, kHeight - 1), s);
            }
    return sum / weights;
}

// An opaque layer that differs from sample to sample, and fragments over two thirds of the image.
TraceHeader patchy_header(int spatial, Random& random) {
    TraceHeader header = test::header_of(kWidth, kHeight, spatial);
    OpaqueLayer layer;
    for (int i = 0; i < kWidth * kHeight * spatial; ++i) {
        for (int c = 0; c < 3; ++c) layer.rgb.push_back(random.real(0, 1));
        layer.depth.push_back(1);
    }
    header.opaque = layer;
    return header;
}
std::vector<Fragment> patchy_fragments(const TraceHeader& header, Random& random) {
    test::FragmentOptions options;
    options.count = std::size_t{kWidth} * kHeight * 4;
    auto fragments = test::random_fragments(header, options, random);
    std::erase_if(fragments, [](const Fragment& f) { return f.x >= 14; });  // the last tiles stay untouched
    return fragments;
}
double opaque_at(const TraceHeader& header, int x, int y, int sample, int channel) {
    const int at = (y * kWidth + x) * header.samples + sample % header.samples;
    return header.opaque->rgb[static_cast<std::size_t>(3 * at + channel)];
}

// The three shapes of resolve: samples over the opaque layer, corrected samples, corrected accumulators.
// Quantities are filtered first and divided afterwards (4.2), the background dimmed sample by sample (3.5).
TEST(GaussianFilter, IsTheConvolutionOfTheSamples) {
    Random random(111);
    for (const int spatial : {1, 4, 16}) {
        const TraceHeader header = patchy_header(spatial, random);
        const auto fragments = patchy_fragments(header, random);
        for (const char* method : {"", ",correction=coverage,total_alpha=sample",
                                   ",method=depth_based,accumulator=sample,total_alpha=sample"})
            for (const char* name : {"stochastic", "laine_karras"}) {
                const std::string technique =
                    name + std::string(":samples=16,format=float32,filter=gaussian") + method;
                TestFrame frame(technique, header, 9);
                frame.draw(fragments);
                const auto image = frame.image();
                const StoredValues stored(frame);
                const bool basic = method[0] == 0;
                const bool depth = std::string(method).find("depth_based") != std::string::npos;
                const std::string color = depth ? "accumulation" : "color";
                for (int i = 0; i < kWidth * kHeight; ++i) {
                    const int x = i % kWidth;
                    const int y = i / kWidth;
                    const auto filtered = [&](auto value) { return gaussian(spatial, 16, x, y, value); };
                    for (int c = 0; c < 3; ++c) {
                        const double sum =
                            filtered([&](int u, int v, int s) { return stored.value(color, u, v, s, c); });
                        double expected = sum;
                        if (!basic) {
                            const double weight = filtered(
                                [&](int u, int v, int s) { return stored.value(color, u, v, s, 3); });
                            const double clear = filtered(
                                [&](int u, int v, int s) { return stored.value("total_alpha", u, v, s, 0); });
                            const double behind = filtered([&](int u, int v, int s) {
                                return stored.value("total_alpha", u, v, s, 0) *
                                       opaque_at(header, u, v, s, c);
                            });
                            expected = (weight > 0 ? (1 - clear) * sum / weight : 0) + behind;
                        }
                        ASSERT_NEAR(image[static_cast<std::size_t>(3 * i + c)], expected, 2e-5)
                            << technique << " " << spatial << " at " << x << "," << y;
                    }
                }
            }
    }
}

// The samples of all neighbours weigh as much as they should: a flat field stays what it is.
TEST(GaussianFilter, LeavesAFlatFieldAlone) {
    for (const int spatial : {1, 2, 8}) {
        const TraceHeader header = test::header_of(kWidth, kHeight, spatial, {0.75f, 0.25f, 0.5f});
        for (const char* method : {",correction=coverage,total_alpha=sample",
                                   ",method=depth_based,accumulator=sample,total_alpha=sample"}) {
            const auto image = test::image_of(
                std::string("stochastic:format=float32,filter=gaussian") + method, header,
                test::everywhere(header, {test::fragment_at(0, 0, 0.5f, 0.5f, {0.25f, 0.5f, 1})}));
            for (std::size_t i = 0; i < image.size(); ++i)
                ASSERT_NEAR(image[i], (i % 3 == 0 ? 0.5 : i % 3 == 1 ? 0.375 : 0.75), 1e-6) << method;
        }
        const auto empty = test::image_of("stochastic:format=float32,filter=gaussian", header, {});
        for (std::size_t i = 0; i < empty.size(); ++i)
            ASSERT_NEAR(empty[i], (i % 3 == 0 ? 0.75 : i % 3 == 1 ? 0.25 : 0.5), 1e-6);
    }
}

// Black of .45 over white of 1/2, of .9 from x = 32 on: noise in D and none in total alpha.
constexpr int kSide = 64;
std::vector<float> two_fields(const std::string& parameters) {
    const TraceHeader header = test::header_of(kSide, kSide, 1, {0, 0, 0});
    std::vector<Fragment> fragments =
        test::everywhere(header, {test::fragment_at(0, 0, 0.6f, 0.5f, {1, 1, 1}, 0),
                                  test::fragment_at(0, 0, 0.3f, 0.45f, {0, 0, 0}, 1)});
    for (Fragment& f : fragments)
        if (f.x >= kSide / 2 && f.primitive == 0) f = test::fragment_at(f.x, f.y, f.z, 0.9f, {1, 1, 1}, 0);
    return test::image_of("stochastic:method=depth_based,format=float32" + parameters, header, fragments);
}
// Over the pixels of columns [from, to) and rows away from the border.
test::Moments of_columns(const std::vector<float>& image, int from, int to) {
    std::vector<std::pair<double, double>> values;
    for (int y = 4; y < kSide - 4; ++y)
        for (int x = from; x < to; ++x)
            values.emplace_back(image[static_cast<std::size_t>(3 * (y * kSide + x))],
                                1.0 / ((to - from) * (kSide - 8)));
    return test::moments_of(values);
}

// Weights are Gaussian in distance, of half the radius as its standard deviation: variance falls by the sum
// of their squares, in a flat region, and the mean stays. Neighbours in the filtered image are correlated, so
// that some 1/20 as many are independent: a relative error of .16 in variance, one standard deviation.
TEST(CrossFilter, AveragesFlatRegions) {
    double sum = 0;
    double squares = 0;
    for (int dy = -2; dy <= 2; ++dy)
        for (int dx = -2; dx <= 2; ++dx) {
            const double weight = std::exp(-(dx * dx + dy * dy) / 2.0);
            sum += weight;
            squares += weight * weight;
        }
    const test::Moments plain = of_columns(two_fields(""), 4, kSide / 2 - 4);
    const test::Moments filtered = of_columns(two_fields(",cross_filter=2"), 4, kSide / 2 - 4);
    EXPECT_NEAR(filtered.variance / plain.variance, squares / (sum * sum), 0.5 * squares / (sum * sum));
    EXPECT_NEAR(filtered.mean, plain.mean, 4 * plain.deviation() / std::sqrt(24 * 56));
    // What has no noise is unchanged: one layer, whatever the filter.
    const std::vector<Fragment> layer = {test::fragment_at(0, 0, 0.5f, 0.3f, {1, 0.5f, 0.25f})};
    const auto image = test::image_of_layers("stochastic:method=depth_based,format=float32,cross_filter=4",
                                             layer, {0, 0, 1}, 32);
    for (std::size_t i = 0; i < image.size(); i += 3) {
        ASSERT_NEAR(image[i], 0.3, 1e-6);
        ASSERT_NEAR(image[i + 1], 0.15, 1e-6);
        ASSERT_NEAR(image[i + 2], 0.075 + 0.7, 1e-6);
    }
}

// "To preserve edges from all visible layers of transparency": where total alpha has an edge, .725 to .945,
// the columns beside it keep their side's colour; a filter that does not look at it blurs them.
TEST(CrossFilter, PreservesEdgesOfTotalAlpha) {
    const auto sharp = two_fields(",cross_filter=3");
    const auto blurred = two_fields(",cross_filter=3,cross_sigma=1");
    const test::Moments left = of_columns(sharp, 4, 28);
    const test::Moments right = of_columns(sharp, 36, 60);
    ASSERT_GT(right.mean - left.mean, 0.15);
    // exp(-.22^2 / (2 x .05^2)) is 6e-5: nothing comes across. Half a window averages half as much, and some
    // 6 rows of a column share theirs.
    const double shrink = 4 * std::sqrt(2.0) / std::sqrt(56.0 / 6);
    EXPECT_NEAR(of_columns(sharp, 31, 32).mean, left.mean, shrink * left.deviation() + 1e-4);
    EXPECT_NEAR(of_columns(sharp, 32, 33).mean, right.mean, shrink * right.deviation() + 1e-4);
    EXPECT_GT(of_columns(blurred, 31, 32).mean, left.mean + 0.2 * (right.mean - left.mean));
    EXPECT_LT(of_columns(blurred, 32, 33).mean, right.mean - 0.2 * (right.mean - left.mean));
}

}  // namespace
}  // namespace ropsim
