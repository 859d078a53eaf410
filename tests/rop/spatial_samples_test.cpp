// Stored samples over a trace of several spatial ones (Enderton et al. 2011, section 3.5): depth at each
// sample, edges of total alpha and of the background.
#include "rop/reference.h"
#include "tests/rop/pixel_moments.h"

#include <filesystem>

#include <unistd.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

constexpr int kSide = 16;

// The exact image, of a trace written for it: 3 channels a pixel.
std::vector<float> reference_of(TraceHeader header, const FragmentChunk& chunk) {
    header.draws.resize(4);
    header.depth_slopes = !chunk.slopes.empty();
    std::string directory = testing::TempDir() + "ropsim_spatial_XXXXXX";
    CHECK(mkdtemp(directory.data()) != nullptr);
    std::vector<float> rgb;
    {
        TraceWriter writer(directory + "/test.trace", header);
        writer.append(chunk);
        writer.finish();
        TraceReader reader(directory + "/test.trace");
        const Image image = reference_image(reader, 1);
        for (int i = 0; i < header.width * header.height; ++i)
            rgb.insert(rgb.end(), image.pixel(i % header.width, i / header.width),
                       image.pixel(i % header.width, i / header.width) + 3);
    }
    std::filesystem::remove_all(directory);
    return rgb;
}

std::vector<float> drawn(const std::string& technique, const TraceHeader& header, const FragmentChunk& chunk,
                         std::uint64_t seed = 5) {
    TestFrame frame(technique, header, seed);
    frame.draw(chunk.fragments, chunk.slopes);
    return frame.image();
}
void expect_equal(const std::vector<float>& a, const std::vector<float>& b, double tolerance,
                  const std::string& what) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], tolerance) << what << " at " << i;
}

// Opaque fragments on random planes, several a pixel, that cross inside it: each sample keeps the nearest at
// its own place.
TEST(SampleDepth, CrossingPlanesAreOrderedSampleBySample) {
    Random random(101);
    for (const int spatial : {2, 4, 8}) {
        const TraceHeader header = test::header_of(kSide, kSide, spatial, {0.5f, 0.25f, 1});
        test::FragmentOptions options;
        options.count = std::size_t{kSide} * kSide * 4;
        FragmentChunk chunk;
        chunk.fragments = test::random_fragments(header, options, random);
        for (Fragment& f : chunk.fragments) {
            f.z = random.real(0.4, 0.6);
            f.a = 1;
            f.r = random.real(0, 1);
            chunk.slopes.push_back({random.real(-0.3, 0.3), random.real(-0.3, 0.3)});
        }
        const auto exact = reference_of(header, chunk);
        for (const char* technique :
             {"stochastic:", "stochastic:masks=coin,", "stochastic:depth_test=first,",
              "laine_karras:", "stochastic:method=depth_based,correction=none,accumulator=sample,",
              "stochastic:correction=coverage,", "laine_karras:method=depth_based,"})
            for (const char* samples : {"samples=8", "samples=32"})
                expect_equal(drawn(technique + std::string("format=float32,") + samples, header, chunk),
                             exact, 1e-6, technique);
        FragmentChunk centres = chunk;
        centres.slopes.clear();
        EXPECT_NE(drawn("laine_karras:format=float32", header, centres),
                  drawn("laine_karras:format=float32", header, chunk));
    }
}

// "There is an edge in the background pixel that corresponds to the edge of the transparent material": half
// the samples are white and covered by a green layer of alpha 1/2, the others black and not. Dimmed sample by
// sample the white half is left with 1/2: 1/4 in all. One total alpha a pixel, 1/4, dims the mean, 1/2, to
// 3/8.
TEST(Background, IsDimmedSampleBySample) {
    TraceHeader header = test::header_of(kSide, kSide, 4);
    OpaqueLayer layer;
    for (int i = 0; i < kSide * kSide; ++i)
        for (const float grey : {1.0f, 1.0f, 0.0f, 0.0f}) {
            layer.rgb.insert(layer.rgb.end(), {grey, grey, grey});
            layer.depth.push_back(1);
        }
    header.opaque = layer;
    Fragment pane = test::fragment_at(0, 0, 0.5f, 0.5f, {0, 1, 0});
    pane.coverage = 0b0011;
    FragmentChunk chunk;
    chunk.fragments = test::everywhere(header, {pane});
    const auto exact = reference_of(header, chunk);
    EXPECT_EQ(exact[0], 0.25f);
    EXPECT_EQ(exact[1], 0.5f);
    for (const char* method :
         {"stochastic:correction=coverage,", "stochastic:method=depth_based,",
          "laine_karras:method=depth_based,", "stochastic:method=depth_based,passes=merged,",
          "laine_karras:correction=coverage,passes=merged,"}) {
        const std::string technique = method + std::string("format=float32,samples=16");
        const bool merged = technique.find("passes=merged") != std::string::npos &&
                            technique.find("depth_based") != std::string::npos;
        expect_equal(drawn(technique + ",total_alpha=sample", header, chunk), exact, 1e-6, technique);
        const auto pixel =
            drawn(technique + ",total_alpha=pixel" + (merged ? ",accumulator=pixel" : ""), header, chunk);
        for (std::size_t i = 0; i < pixel.size(); i += 3) {
            ASSERT_NEAR(pixel[i], 0.375, 1e-6) << technique;
            ASSERT_NEAR(pixel[i + 1], 0.25 + 0.375, 1e-6) << technique;
        }
        // Per sample is what a trace of several samples gets.
        EXPECT_EQ(drawn(technique, header, chunk), drawn(technique + ",total_alpha=sample", header, chunk));
    }
}

// "When the accumulated samples are averaged for display, the effect is that the fragment is multiplied by
// (4)": accumulating into each sample is accumulating into the pixel with svis, with slopes, partial coverage
// and an opaque layer.
TEST(Accumulator, SamplesAverageToThePixels) {
    Random random(102);
    for (const int spatial : {1, 4}) {
        const TraceHeader header = test::opaque_header(kSide, kSide, spatial, random);
        test::FragmentOptions options;
        options.count = std::size_t{kSide} * kSide * 5;
        FragmentChunk chunk;
        chunk.fragments = test::random_fragments(header, options, random);
        for (std::size_t i = 0; i < chunk.fragments.size(); ++i)
            chunk.slopes.push_back({random.real(-0.1, 0.1), random.real(-0.1, 0.1)});
        for (const char* technique : {"stochastic", "laine_karras"})
            for (const char* correction : {"none", "coverage", "accumulated"}) {
                const std::string text = technique +
                                         std::string(
                                             ":method=depth_based,format=float32,samples=16,"
                                             "correction=") +
                                         correction;
                const auto pixel = drawn(text + ",accumulator=pixel", header, chunk);
                expect_equal(drawn(text + ",accumulator=sample", header, chunk), pixel, 1e-5, text);
                if (std::string(correction) == "none") continue;
                expect_equal(
                    drawn(text + ",accumulator=sample,total_alpha=sample,passes=merged", header, chunk),
                    drawn(text + ",total_alpha=sample", header, chunk), 1e-5, text);
            }
    }
}

// Total alpha a sample is exact at edges; a pixel's takes parts of the pixel for thin wholes: two halves side
// by side, opaque, are one opaque surface, and 1 - (1/2)^2 = 3/4 of one a pixel.
TEST(TotalAlpha, KnowsEdgesASampleAndNotAPixel) {
    const TraceHeader header = test::header_of(8, 8, 4, {0, 0, 1});
    std::vector<Fragment> halves(2, test::fragment_at(0, 0, 0.5f, 1, {1, 0, 0}));
    halves[0].coverage = 0b0011;
    halves[1].coverage = 0b1100;
    halves[1].primitive = 1;
    FragmentChunk chunk;
    chunk.fragments = test::everywhere(header, halves);
    const auto sample = drawn("stochastic:method=depth_based,total_alpha=sample", header, chunk);
    const auto pixel = drawn("stochastic:method=depth_based,total_alpha=pixel", header, chunk);
    for (std::size_t i = 0; i < sample.size(); i += 3) {
        ASSERT_EQ(sample[i], 1.0f);
        ASSERT_EQ(sample[i + 2], 0.0f);
        ASSERT_EQ(pixel[i], 0.75f);
        ASSERT_EQ(pixel[i + 2], 0.25f);
    }
}

}  // namespace
}  // namespace ropsim
