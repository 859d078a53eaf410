// The reference of coloured transmission: McGuire and Mara 2017, equation 1, against closed forms and against
// two-pass sorted blending as their footnote 1 describes it: back to front, modulate what is there, then add.
#include "base/random.h"
#include "rop/reference.h"
#include "tests/traces/scratch.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using Rgb = std::array<double, 3>;

TraceHeader header_of(int width, int height, int samples, bool materials = true) {
    TraceHeader header;
    header.width = width;
    header.height = height;
    header.samples = samples;
    header.background = {1, 1, 1};
    header.draws.resize(1);
    header.materials = materials;
    header.depth_slopes = samples > 1;
    return header;
}

class ColoredReference : public ScratchTest {
 protected:
    // The chunk's materials are left out where the header has none.
    std::string write(const TraceHeader& header, FragmentChunk chunk) const {
        if (header.depth_slopes && chunk.slopes.empty()) chunk.slopes.resize(chunk.size());
        if (!header.materials) chunk.materials.clear();
        TraceWriter writer(path("test.trace"), header);
        writer.append(chunk);
        writer.finish();
        return path("test.trace");
    }
    Image reference(const TraceHeader& header, const FragmentChunk& chunk,
                    Transmission transmission = Transmission::kColored) const {
        TraceReader reader(write(header, chunk));
        return reference_image(reader, 2, DisplayFilter::kBox, kReferenceBandFragments, transmission);
    }
};

void add(FragmentChunk& chunk, float z, Rgb premultiplied, float alpha, Rgb transmission) {
    Fragment f{};
    f.z = z;
    f.r = static_cast<float>(premultiplied[0]);
    f.g = static_cast<float>(premultiplied[1]);
    f.b = static_cast<float>(premultiplied[2]);
    f.a = alpha;
    f.coverage = 1;
    Material m;
    for (std::size_t c = 0; c < 3; ++c) m.transmission[c] = static_cast<float>(transmission[c]);
    chunk.fragments.push_back(f);
    chunk.materials.push_back(m);
}

void expect_pixel(const Image& image, int x, int y, const std::vector<double>& expected,
                  double tolerance = 1e-6) {
    for (std::size_t c = 0; c < expected.size(); ++c)
        EXPECT_NEAR(image.pixel(x, y)[c], expected[c], tolerance)
            << image.channels[c] << " at " << x << "," << y;
}

// A yellow pane over a cyan one leaves green; each alone covers everything, so alpha sees the front one only.
TEST_F(ColoredReference, TwoPanesMultiplyTheirColors) {
    FragmentChunk panes;
    add(panes, .6f, {0, 0, 0}, 1, {0, 1, 1});
    add(panes, .3f, {.0625, 0, 0}, 1, {1, 1, .25});
    const TraceHeader header = header_of(1, 1, 1);
    const Image image = reference(header, panes);
    EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A", "layers", "ties"}));
    expect_pixel(image, 0, 0, {.0625, 1, .25, 1, 2, 0}, 0);
    expect_pixel(reference(header, panes, Transmission::kAlpha), 0, 0, {.0625, 0, 0, 1, 2, 0}, 0);
}

// What the front pane lets through colours what the one behind it reflects, not the other way round.
TEST_F(ColoredReference, OnlyWhatIsBehindIsColored) {
    FragmentChunk panes;
    add(panes, .3f, {.5, .5, .5}, .5f, {1, .5, 0});
    add(panes, .6f, {.25, .25, .25}, .5f, {0, 0, 0});
    // Of the background .5 * (1, .75, .5); of the rear pane's .25 the same share.
    expect_pixel(reference(header_of(1, 1, 1), panes), 0, 0,
                 {.5 + .25 + .5, .5 + .1875 + .375, .5 + .125 + .25, .75, 2, 0}, 0);
}

TEST_F(ColoredReference, OfEqualDepthsTheEarlierIsNearer) {
    FragmentChunk panes;
    add(panes, .5f, {1, 0, 0}, 1, {0, .5, 0});
    add(panes, .5f, {0, 1, 0}, 1, {1, 1, 1});
    expect_pixel(reference(header_of(1, 1, 1), panes), 0, 0, {1, 1, 0, 1, 2, 1}, 0);
    std::swap(panes.fragments[0], panes.fragments[1]);
    std::swap(panes.materials[0], panes.materials[1]);
    expect_pixel(reference(header_of(1, 1, 1), panes), 0, 0, {1, 1.5, 0, 1, 2, 1}, 0);
}

// Equation 1 knows alpha (1 - t) alone: the same glass with full coverage and with the least.
TEST_F(ColoredReference, PairsOfAlphaAndTransmissionThatMeanTheSame) {
    FragmentChunk full, least;
    for (int i = 0; i < 3; ++i) {
        const float z = .25f * static_cast<float>(i);
        add(full, z, {.125, .25, 0}, 1, {.875, .75, .5});
        add(least, z, {.125, .25, 0}, .5f, {.75, .5, 0});
    }
    const TraceHeader header = header_of(1, 1, 1);
    const Image image = reference(header, full), other = reference(header, least);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(image.values[c], other.values[c]);
    EXPECT_EQ(image.values[3], 1);
    EXPECT_EQ(other.values[3], .875);
}

FragmentChunk random_chunk(const TraceHeader& header, int count, std::uint64_t seed) {
    FragmentChunk chunk;
    for (int i = 0; i < count; ++i) {
        const auto key = mix64(seed + static_cast<std::uint64_t>(i));
        const auto pick = [&](std::uint32_t stream, int below) {
            return static_cast<int>(random_bits(key, stream) % static_cast<std::uint32_t>(below));
        };
        const auto rgb = [&](std::uint32_t stream) {
            return Rgb{random_unit(key, stream), random_unit(key, stream + 1), random_unit(key, stream + 2)};
        };
        // Few depths, so that ties are frequent; transmission and alpha also at their ends.
        const int end = pick(0, 4);
        const float alpha = end == 0 ? 1 : random_unit(key, 1);
        add(chunk, static_cast<float>(pick(2, 32)) / 32.f, rgb(3), alpha,
            end == 1   ? Rgb{1, 1, 1}
            : end == 2 ? Rgb{0, 0, 0}
                       : rgb(6));
        Fragment& f = chunk.fragments.back();
        f.x = static_cast<std::uint16_t>(pick(9, header.width));
        f.y = static_cast<std::uint16_t>(pick(10, header.height));
        f.coverage = static_cast<std::uint16_t>(pick(11, 1 << header.samples));
        f.primitive = static_cast<std::uint32_t>(i);
    }
    return chunk;
}

// As a painter would, whole image by whole image: from the farthest fragment to the nearest, of equal depths
// the later first, two passes each.
std::vector<double> two_pass_blending(const TraceHeader& header, const FragmentChunk& chunk) {
    const auto samples = static_cast<std::size_t>(header.samples);
    const auto pixels = static_cast<std::size_t>(header.width * header.height);
    std::vector<double> target(header.opaque->rgb.begin(), header.opaque->rgb.end());
    std::vector<std::size_t> order(chunk.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return chunk.fragments[a].z < chunk.fragments[b].z;
    });
    std::reverse(order.begin(), order.end());
    for (const std::size_t i : order) {
        const Fragment& f = chunk.fragments[i];
        const auto pixel = static_cast<std::size_t>(f.y * header.width + f.x);
        for (std::size_t m = 0; m < samples; ++m) {
            const std::size_t at = pixel * samples + m;
            if ((f.coverage >> m & 1) == 0 || !(f.z < header.opaque->depth[at])) continue;
            for (std::size_t c = 0; c < 3; ++c) {
                const double a = f.a, t = chunk.materials[i].transmission[c];
                target[3 * at + c] *= a * t + (1 - a);
            }
            target[3 * at] += f.r, target[3 * at + 1] += f.g, target[3 * at + 2] += f.b;
        }
    }
    std::vector<double> image(3 * pixels);
    for (std::size_t i = 0; i < target.size(); ++i)
        image[i / (3 * samples) * 3 + i % 3] += target[i] / header.samples;
    return image;
}

TraceHeader random_header(int width, int height, int samples) {
    TraceHeader header = header_of(width, height, samples);
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

TEST_F(ColoredReference, IsTwoPassSortedBlending) {
    for (const int samples : {1, 4}) {
        const TraceHeader header = random_header(19, 11, samples);
        const FragmentChunk chunk = random_chunk(header, 3000, 5);
        const Image image = reference(header, chunk);
        const Image alpha = reference(header, chunk, Transmission::kAlpha);
        FragmentChunk opaque = chunk;
        for (Material& m : opaque.materials) std::fill_n(m.transmission, 3, 0.0f);
        const Image covered = reference(header, opaque, Transmission::kAlpha);
        const std::vector<double> expected = two_pass_blending(header, chunk);
        double difference = 0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            const std::size_t at = i / 3 * 6 + i % 3;
            EXPECT_NEAR(image.values[at], expected[i], 1e-6 * (1 + expected[i])) << i;
            difference = std::max(difference, std::abs(image.values[at] - double{alpha.values[at]}));
            for (const std::size_t c : {3u, 4u, 5u})
                EXPECT_EQ(image.values[i / 3 * 6 + c], covered.values[i / 3 * 6 + c])
                    << "total alpha, counts";
        }
        EXPECT_GT(difference, .5);
    }
}

// What is left of the background is beta, the product of equation 2, in whatever order it arrives.
TEST_F(ColoredReference, BlackGlassLeavesBetaOfTheBackground) {
    TraceHeader header = header_of(1, 1, 1);
    FragmentChunk chunk = random_chunk(header, 40, 8);
    Rgb beta = {1, 1, 1};
    for (std::size_t i = 0; i < chunk.size(); ++i) {
        Fragment& f = chunk.fragments[i];
        f.r = f.g = f.b = 0;
        f.a *= .25f;
        f.coverage = 1;
        for (std::size_t c = 0; c < 3; ++c)
            beta[c] *= 1 - double{f.a} + double{f.a} * double{chunk.materials[i].transmission[c]};
    }
    for (int turn = 0; turn < 3; ++turn) {
        expect_pixel(reference(header, chunk), 0, 0, {beta[0], beta[1], beta[2]}, 1e-7);
        std::rotate(chunk.fragments.begin(), chunk.fragments.begin() + 13, chunk.fragments.end());
        std::rotate(chunk.materials.begin(), chunk.materials.begin() + 13, chunk.materials.end());
    }
}

TEST_F(ColoredReference, WhatTransmitsNothingIsTheAlphaReferenceBitForBit) {
    for (const int samples : {1, 4}) {
        TraceHeader header = random_header(19, 11, samples);
        FragmentChunk chunk = random_chunk(header, 2000, 6);
        for (Material& m : chunk.materials) std::fill_n(m.transmission, 3, 0.0f);
        const Image alpha = reference(header, chunk, Transmission::kAlpha);
        EXPECT_EQ(reference(header, chunk).values, alpha.values);
        header.materials = false;
        EXPECT_EQ(reference(header, chunk).values, alpha.values);
    }
}

// Who knows alpha alone is given the least that means the same: a pane without colour composites as it does
// in colours, whatever pair of coverage and transmission says it, and total alpha is what it takes away.
TEST_F(ColoredReference, AlphaAloneSeesGreyGlassRight) {
    for (const float coverage : {1.f, .5f}) {
        FragmentChunk panes;
        const float t = 1 - .375f / coverage;
        add(panes, .3f, {.125, .25, 0}, coverage, {t, t, t});
        add(panes, .6f, {.25, 0, .5}, 1, {.5, .5, .5});
        const std::vector<double> expected = {
            .125 + .625 * (.25 + .5), .25 + .625 * .5, .625, 1 - .3125, 2, 0};
        expect_pixel(reference(header_of(1, 1, 1), panes, Transmission::kAlpha), 0, 0, expected);
        const Image colored = reference(header_of(1, 1, 1), panes);
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(colored.pixel(0, 0)[c], expected[c], 1e-6);
    }
}

TEST_F(ColoredReference, ClearGlassOfAnyCoverageChangesNothing) {
    TraceHeader header = header_of(1, 1, 1);
    header.background = {.1f, .7f, 3.3f};
    FragmentChunk chunk;
    for (const float alpha : {1.f, .1f, .3f, 1e-12f, 1.f / 255})
        add(chunk, alpha, {0, 0, 0}, alpha, {1, 1, 1});
    const Image image = reference(header, chunk);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(image.values[static_cast<std::size_t>(c)], header.background[c]);
}

TEST_F(ColoredReference, BandsAndThreadsChangeNothing) {
    const TraceHeader header = random_header(35, 26, 2);
    TraceReader reader(write(header, random_chunk(header, 4000, 9)));
    const Image whole = reference_image(reader, 1, DisplayFilter::kBox, 1u << 20, Transmission::kColored);
    for (const std::uint64_t band : {1u, 300u, 1000u})
        EXPECT_EQ(reference_image(reader, 3, DisplayFilter::kBox, band, Transmission::kColored).values,
                  whole.values);
}

// Each of the two references has a file of its own in the cache; without materials there is one image.
TEST_F(ColoredReference, IsCachedApart) {
    ASSERT_EQ(setenv("XDG_CACHE_HOME", path("").c_str(), 1), 0);
    TraceHeader header = random_header(12, 9, 1);
    const FragmentChunk chunk = random_chunk(header, 300, 3);
    const auto cached = [&](TraceReader& reader, DisplayFilter filter, Transmission transmission) {
        return cached_reference_image(reader, 1, filter, transmission).values;
    };
    const auto kept = [&](const TraceReader& reader, const std::string& suffix) {
        return std::filesystem::exists(path("ropsim/" + reader.hash() + suffix));
    };
    TraceReader reader(write(header, chunk));
    const auto colored = cached(reader, DisplayFilter::kBox, Transmission::kColored);
    EXPECT_EQ(colored,
              reference_image(reader, 1, DisplayFilter::kBox, 1u << 20, Transmission::kColored).values);
    EXPECT_TRUE(kept(reader, "-colored-v3.exr"));
    EXPECT_FALSE(kept(reader, "-v3.exr"));
    EXPECT_EQ(cached(reader, DisplayFilter::kBox, Transmission::kAlpha), reference_image(reader, 1).values);
    EXPECT_EQ(cached(reader, DisplayFilter::kBox, Transmission::kColored), colored);
    EXPECT_NE(cached(reader, DisplayFilter::kGaussian, Transmission::kColored), colored);
    EXPECT_TRUE(kept(reader, "-gaussian-colored-v3.exr"));
    header.materials = false;
    TraceReader plain(write(header, chunk));
    EXPECT_EQ(cached(plain, DisplayFilter::kBox, Transmission::kColored), reference_image(plain, 1).values);
    EXPECT_TRUE(kept(plain, "-v3.exr"));
    EXPECT_FALSE(kept(plain, "-colored-v3.exr"));
}

}  // namespace
}  // namespace ropsim
