// Exact compositing against hand calculations from the literature and a brute-force evaluation per pixel.
#include "rop/reference.h"

#include "base/atomic_file.h"
#include "base/random.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include <gtest/gtest.h>
#include <unistd.h>

namespace ropsim {
namespace {

class Reference : public testing::Test {
 protected:
    void SetUp() override {
        std::string pattern = testing::TempDir() + "ropsim_reference_XXXXXX";
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        directory_ = pattern;
    }
    void TearDown() override { std::filesystem::remove_all(directory_); }

    std::string write(const TraceHeader& header, const std::vector<Fragment>& fragments) {
        std::string path = (directory_ / "test.trace").string();
        TraceWriter writer(path, header);
        writer.append(fragments);
        writer.finish();
        return path;
    }
    Image reference(const TraceHeader& header, const std::vector<Fragment>& fragments) {
        TraceReader reader(write(header, fragments));
        return reference_image(reader, 2);
    }
    std::filesystem::path directory_;
};

TraceHeader header_of(int width, int height, int samples, glm::vec3 background) {
    TraceHeader header;
    header.width = width;
    header.height = height;
    header.samples = samples;
    header.background = background;
    header.draws.resize(1);
    return header;
}

Fragment fragment(float z, glm::vec3 straight, float alpha, std::uint16_t coverage = 1) {
    Fragment f{};
    f.z = z;
    f.r = straight.r * alpha;
    f.g = straight.g * alpha;
    f.b = straight.b * alpha;
    f.a = alpha;
    f.coverage = coverage;
    return f;
}

void expect_pixel(const Image& image, int x, int y, const std::vector<double>& expected) {
    for (std::size_t c = 0; c < expected.size(); ++c)
        EXPECT_NEAR(image.pixel(x, y)[c], expected[c], 1e-6) << image.channels[c] << " at " << x << "," << y;
}

// Enderton et al. 2011, section 3.1, example 1: red in front of green before blue, arriving back to front.
TEST_F(Reference, RedBeforeGreenBeforeBlue) {
    const Image image = reference(header_of(1, 1, 1, {0, 0, 1}),
                                  {fragment(.6f, {0, 1, 0}, .45f), fragment(.3f, {1, 0, 0}, .45f)});
    EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A", "layers", "ties"}));
    expect_pixel(image, 0, 0, {.45, .2475, .3025, 1 - .3025, 2, 0});
}

// The same, example 2: four white sheets of alpha 1/4 before grey 1/4.
TEST_F(Reference, FourSheetsOfSmoke) {
    std::vector<Fragment> sheets;
    for (const float z : {.4f, .1f, .3f, .2f}) sheets.push_back(fragment(z, {1, 1, 1}, .25f));
    expect_pixel(reference(header_of(1, 1, 1, {.25f, .25f, .25f}), sheets), 0, 0,
                 {.7626953125, .7626953125, .7626953125, .68359375, 4, 0});
}

TEST_F(Reference, OfEqualDepthsTheEarlierIsNearer) {
    const Image image =
        reference(header_of(1, 1, 1, {0, 0, 0}),
                  {fragment(.5f, {1, 0, 0}, 1), fragment(.5f, {0, 1, 0}, 1), fragment(.7f, {0, 0, 1}, 1)});
    expect_pixel(image, 0, 0, {1, 0, 0, 1, 3, 1});
}

TEST_F(Reference, NegativeZeroDepthTiesWithZero) {
    const Image image =
        reference(header_of(1, 1, 1, {0, 0, 0}), {fragment(0.f, {1, 0, 0}, 1), fragment(-0.f, {0, 1, 0}, 1)});
    expect_pixel(image, 0, 0, {1, 0, 0, 1, 2, 1});
}

TEST_F(Reference, OpaqueLayerHidesWhatIsNotNearer) {
    TraceHeader header = header_of(2, 1, 1, {9, 9, 9});
    header.draws.resize(2);
    header.draws[1].depth_test = false;
    header.opaque = OpaqueLayer{{0, 0, 1, 0, 0, 1}, {.5f, std::numeric_limits<float>::infinity()}};
    Fragment at_depth = fragment(.5f, {1, 0, 0}, .5f);
    Fragment untested = fragment(.9f, {0, 1, 0}, .5f);
    untested.draw = 1;
    Fragment right = at_depth;
    right.x = 1;
    const Image image = reference(header, {at_depth, untested, right});
    expect_pixel(image, 0, 0, {0, .5, .5, .5, 1, 0});
    expect_pixel(image, 1, 0, {.5, 0, .5, .5, 1, 0});
}

// Two of four samples opaque red, one of those and one other half green behind it.
TEST_F(Reference, SamplesAreCompositedAloneAndAveraged) {
    const Image image = reference(header_of(1, 1, 4, {0, 0, 1}),
                                  {fragment(.7f, {0, 1, 0}, .5f, 0b0110), fragment(.2f, {1, 0, 0}, 1, 0b0011),
                                   fragment(.1f, {1, 1, 1}, 1, 0)});
    expect_pixel(image, 0, 0, {.5, .125, .375, (1 + 1 + .5 + 0) / 4, 2, 0});
}

// Two planes that cross within the pixel, each in front at two of the four samples; then one plane against an
// opaque layer whose depth differs from sample to sample.
TEST_F(Reference, PlanesThatCrossAreOrderedSampleBySample) {
    TraceHeader header = header_of(1, 1, 4, {0, 0, 0});
    header.depth_slopes = true;
    FragmentChunk chunk;
    chunk.fragments = {fragment(.5f, {1, 0, 0}, 1, 0b1111), fragment(.5f, {0, 1, 0}, 1, 0b1111)};
    chunk.slopes = {{0, 0}, {.25f, 0}};  // green is nearer on the left: samples 0 and 2
    const auto composited = [&] {
        const std::string path = (directory_ / "crossing.trace").string();
        TraceWriter writer(path, header);
        writer.append(chunk);
        writer.finish();
        TraceReader trace(path);
        return reference_image(trace, 1);
    };
    expect_pixel(composited(), 0, 0, {.5, .5, 0, 1, 2, 1});
    header.opaque = OpaqueLayer{{0, 0, .25f, 0, 0, .5f, 0, 0, .75f, 0, 0, 1}, {.4f, .4f, .6f, .6f}};
    chunk.fragments.pop_back();
    chunk.slopes.pop_back();
    chunk.fragments[0].a = .5f;
    chunk.fragments[0].r = .5f;
    expect_pixel(composited(), 0, 0, {.25, 0, (.25 + .5 + .375 + .5) / 4, .25, 1, 0});
    chunk.slopes[0] = {0, .6f};  // at the samples: .275, .425, .575, .725
    expect_pixel(composited(), 0, 0, {.25, 0, (.125 + .5 + .375 + 1) / 4, .25, 1, 0});
}

// Small integers as depths, so that ties are frequent.
std::vector<Fragment> random_fragments(const TraceHeader& header, int count, std::uint64_t seed) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < count; ++i) {
        const auto key = mix64(seed + static_cast<std::uint64_t>(i));
        const auto pick = [&](std::uint32_t stream, int below) {
            return static_cast<int>(random_bits(key, stream) % static_cast<std::uint32_t>(below));
        };
        Fragment f =
            fragment(static_cast<float>(pick(0, 32)) / 32.f,
                     {random_unit(key, 1), random_unit(key, 2), random_unit(key, 3)}, random_unit(key, 4));
        f.x = static_cast<std::uint16_t>(pick(5, header.width));
        f.y = static_cast<std::uint16_t>(pick(6, header.height));
        f.coverage = static_cast<std::uint16_t>(pick(7, 1 << header.samples));
        f.primitive = static_cast<std::uint32_t>(i);
        fragments.push_back(f);
    }
    return fragments;
}

// Every fragment weighted by the product of the transmittances of all that are before it: no sorting at all.
std::vector<double> brute_force(const TraceHeader& header, const std::vector<Fragment>& fragments, int x,
                                int y) {
    std::vector<double> rgba(4, 0.0);
    for (int m = 0; m < header.samples; ++m) {
        const auto at = static_cast<std::size_t>((y * header.width + x) * header.samples + m);
        const auto here = [&](const Fragment& f) {
            return f.x == x && f.y == y && (f.coverage >> m & 1) && f.z < header.opaque->depth[at];
        };
        double through = 1;
        for (std::size_t i = 0; i < fragments.size(); ++i) {
            if (!here(fragments[i])) continue;
            double weight = 1;
            for (std::size_t j = 0; j < fragments.size(); ++j)
                if (here(fragments[j]) &&
                    (fragments[j].z < fragments[i].z || (fragments[j].z == fragments[i].z && j < i)))
                    weight *= 1.0 - fragments[j].a;
            rgba[0] += weight * fragments[i].r, rgba[1] += weight * fragments[i].g,
                rgba[2] += weight * fragments[i].b;
            through *= 1.0 - fragments[i].a;
        }
        for (std::size_t c = 0; c < 3; ++c) rgba[c] += through * header.opaque->rgb[3 * at + c];
        rgba[3] += 1 - through;
    }
    for (double& v : rgba) v /= header.samples;
    return rgba;
}

TraceHeader random_header(int width, int height, int samples) {
    TraceHeader header = header_of(width, height, samples, {0, 0, 0});
    OpaqueLayer opaque;
    for (int i = 0; i < width * height * samples; ++i) {
        const auto key = mix64(static_cast<std::uint64_t>(i) + 77);
        for (std::uint32_t c = 0; c < 3; ++c) opaque.rgb.push_back(random_unit(key, c));
        opaque.depth.push_back(i % 3 == 0 ? std::numeric_limits<float>::infinity()
                                          : .25f + .5f * random_unit(key, 3));
    }
    header.opaque = opaque;
    return header;
}

TEST_F(Reference, AgreesWithBruteForce) {
    for (const int samples : {1, 4}) {
        const TraceHeader header = random_header(19, 11, samples);
        const auto fragments = random_fragments(header, 1500, 5);
        const Image image = reference(header, fragments);
        for (int y = 0; y < header.height; ++y)
            for (int x = 0; x < header.width; ++x)
                expect_pixel(image, x, y, brute_force(header, fragments, x, y));
    }
}

TEST_F(Reference, BandsAndThreadsChangeNothing) {
    const TraceHeader header = random_header(35, 26, 2);
    TraceReader reader(write(header, random_fragments(header, 4000, 9)));
    const Image whole = reference_image(reader, 1);
    for (const std::uint64_t band : {1u, 300u, 1000u})
        EXPECT_EQ(reference_image(reader, 3, DisplayFilter::kBox, band).values, whole.values);
    std::vector<Fragment> chunk;
    std::uint64_t count = 0;
    while (reader.next(chunk)) count += chunk.size();
    EXPECT_EQ(count, 4000u) << "the trace must be left rewound, all tiles selected";
}

TEST_F(Reference, WithoutFragmentsTheBackgroundIsLeft) {
    expect_pixel(reference(header_of(9, 3, 1, {.1f, .2f, .3f}), {}), 8, 2, {.1f, .2f, .3f, 0, 0, 0});
}

TEST_F(Reference, CacheHoldsTheImageAndSurvivesDamage) {
    ASSERT_EQ(setenv("XDG_CACHE_HOME", directory_.c_str(), 1), 0);
    const TraceHeader header = random_header(12, 9, 1);
    TraceReader reader(write(header, random_fragments(header, 300, 3)));
    const Image image = reference_image(reader, 1);
    EXPECT_EQ(cached_reference_image(reader, 1).values, image.values);
    const std::string path = (directory_ / "ropsim" / (reader.hash() + "-v3.exr")).string();
    ASSERT_TRUE(std::filesystem::exists(path));
    Image marked = image;
    marked.values[0] = 42;
    write_exr(path, marked);
    const Image again = cached_reference_image(reader, 1);
    EXPECT_EQ(again.values, marked.values) << "must come from the cache";
    EXPECT_EQ(again.channels, image.channels);
    write_file(path, "not an image");
    EXPECT_EQ(cached_reference_image(reader, 1).values, image.values);
    EXPECT_EQ(read_exr(path).values, image.values) << "the damaged file must be replaced";
}

TEST_F(Reference, ACacheThatCannotExistIsPassedOver) {
    write_file((directory_ / "file").string(), "");
    ASSERT_EQ(setenv("XDG_CACHE_HOME", (directory_ / "file").c_str(), 1), 0);
    TraceReader reader(write(header_of(1, 1, 1, {.5f, .5f, .5f}), {}));
    expect_pixel(cached_reference_image(reader, 1), 0, 0, {.5, .5, .5, 0, 0, 0});
}

}  // namespace
}  // namespace ropsim
