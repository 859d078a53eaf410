// Laine and Karras 2011 against an independent, slow and literal reading of its Figures 2, 4, 5 and 7.
#include "rop/hilbert.h"
#include "tests/rop/random_fragments.h"

#include <set>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// Figure 4, in 64-bit arithmetic modulo 2^32 on an explicitly reversed string of bits; in [0, 1).
double alpha_reference(std::uint64_t index, std::uint64_t surface) {
    constexpr std::uint64_t kModulus = 1ull << 32;
    std::uint64_t x = 0;
    for (int b = 0; b < 32; ++b) x += ((index >> b) % 2) * (kModulus >> (b + 1));
    x = (x + surface) % kModulus;
    for (const std::uint64_t factor : {0x6C50B47Cull, 0xB82F1E52ull, 0xC7AFE638ull, 0x8D22F6E6ull})
        x ^= x * factor % kModulus;
    return static_cast<double>(x) / static_cast<double>(kModulus);
}

// Figure 7 for one pixel, word for word.
class FigureSeven {
 public:
    FigureSeven(std::uint64_t pixel, std::size_t samples, int spatial, float depth,
                std::array<float, 3> background)
        : pixel_(pixel), spatial_(spatial), depth_(samples, depth), color_(samples, background) {}

    void draw(const Fragment& f) {
        std::set<std::size_t> drawn;  // S'
        for (std::size_t s = 0; s < depth_.size(); ++s)
            if ((f.coverage >> (static_cast<int>(s) % spatial_) & 1) != 0 && !(f.z > depth_[s]))
                drawn.insert(s);
        if (std::ranges::any_of(drawn, [&](std::size_t s) { return covered_.contains(s); })) {
            ++surface_;
            covered_.clear();
        }
        std::uint64_t n = covered_.size();
        std::vector<std::size_t> order(drawn.begin(), drawn.end());
        std::ranges::stable_sort(order, {}, [&](std::size_t s) { return depth_[s]; });
        for (const std::size_t s : order) {
            if (static_cast<double>(f.a) > alpha_reference(n + pixel_ * depth_.size(), surface_)) {
                depth_[s] = f.z;
                for (std::size_t c = 0; c < 3; ++c) color_[s][c] = (c == 0 ? f.r : c == 1 ? f.g : f.b) / f.a;
            }
            ++n;
        }
        covered_.insert(drawn.begin(), drawn.end());
    }
    double mean(std::size_t channel) const {
        double sum = 0;
        for (const auto& c : color_) sum += c[channel];
        return sum / static_cast<double>(color_.size());
    }
    const std::vector<float>& depth() const { return depth_; }
    std::uint64_t surface() const { return surface_; }

 private:
    std::uint64_t pixel_;
    int spatial_;
    std::vector<float> depth_;
    std::vector<std::array<float, 3>> color_;
    std::set<std::size_t> covered_;
    std::uint64_t surface_ = 0;
};

struct Case {
    int samples;
    int spatial;
};
class LiteralReading : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Samples, LiteralReading,
                         testing::Values(Case{1, 1}, Case{8, 1}, Case{8, 4}, Case{12, 2}, Case{64, 16}),
                         [](const auto& setup) {
                             return std::to_string(setup.param.samples) + "over" +
                                    std::to_string(setup.param.spatial);
                         });

TEST_P(LiteralReading, GivesTheSameSamples) {
    const auto [samples, spatial] = GetParam();
    Random random(31);
    const TraceHeader header = test::opaque_header(7, 9, spatial, random);
    test::FragmentOptions options;
    options.count = 3000;
    auto fragments = test::random_fragments(header, options, random);
    TestFrame frame("laine_karras:format=float32,samples=" + std::to_string(samples), header);
    frame.draw(fragments);
    const auto image = frame.image();
    for (int y = 0; y < header.height; ++y) {
        for (int x = 0; x < header.width; ++x) {
            const auto background = test::background_of(header, x, y);
            FigureSeven pixel(hilbert_index(4, x, y), static_cast<std::size_t>(samples), spatial,
                              test::opaque_depth(header, x, y),
                              {static_cast<float>(background[0]), static_cast<float>(background[1]),
                               static_cast<float>(background[2])});
            for (const Fragment& f : fragments)
                if (f.x == x && f.y == y) pixel.draw(f);
            const auto words = frame.words(x, y);
            for (std::size_t s = 0; s < pixel.depth().size(); ++s)
                ASSERT_EQ(std::bit_cast<float>(words[s]), pixel.depth()[s])
                    << x << "," << y << " sample " << s;
            ASSERT_EQ(words.back(), pixel.surface()) << x << "," << y;
            for (std::size_t c = 0; c < 3; ++c)
                ASSERT_NEAR(image[static_cast<std::size_t>(3 * (y * header.width + x)) + c], pixel.mean(c),
                            1e-5);
        }
    }
}

// Samples that one fragment of alpha `a` writes in each pixel of a fresh frame after `surfaces` other
// surfaces.
std::vector<std::uint64_t> written_masks(int samples, int side, float a, int surfaces) {
    TestFrame frame("laine_karras:samples=" + std::to_string(samples), test::header_of(side, side));
    // Each of alpha 0 covers every sample of the pixel: it starts a surface and changes nothing.
    for (int s = 0; s <= surfaces; ++s) {
        frame.log().clear_records();
        std::vector<Fragment> layer;
        for (int i = 0; i < side * side; ++i)
            layer.push_back(test::fragment_at(i % side, i / side, 0.5f, s == surfaces ? a : 0.0f, {1, 1, 1}));
        frame.draw(layer);
    }
    std::vector<std::uint64_t> masks;
    for (std::size_t i = 0; i < frame.log().records(); ++i)
        masks.push_back(frame.log().record_access(i)[1].write);
    return masks;
}

// The hash's first values for surface 0, found by asking at and just above each: sample k of pixel 0 gets
// reference k.
TEST(AlphaReference, FirstEightOfSurfaceZero) {
    const std::array<float, 8> expected = {0, .5f, .25f, .75f, .625f, .125f, .875f, .375f};
    for (std::size_t k = 0; k < 8; ++k) {
        EXPECT_EQ(alpha_reference(k, 0), expected[k]);
        const std::uint64_t at = written_masks(8, 1, expected[k], 0)[0];
        const std::uint64_t above = written_masks(8, 1, std::nextafter(expected[k], 1.0f), 0)[0];
        EXPECT_EQ(at >> k & 1, 0u) << "the comparison is strict, reference " << k;
        EXPECT_EQ(above >> k & 1, 1u) << "reference " << k;
    }
}

// An aligned run of 2^k references has one in each of 2^k equal intervals, whatever surface and pixel: alpha
// = j / 2^k covers exactly j samples.
TEST(AlphaReference, AlignedRunsAreStratified) {
    for (const int samples : {4, 16, 64})
        for (const int surface : {0, 1, 2, 13})
            for (int j = 0; j <= samples; j += samples / 4)
                for (const std::uint64_t mask :
                     written_masks(samples, 12, static_cast<float>(j) / static_cast<float>(samples), surface))
                    ASSERT_EQ(std::popcount(mask), j) << samples << " samples, surface " << surface;
}

// Not only alphas on the grid: floor or ceiling of alpha times the samples.
TEST(AlphaReference, AnyAlphaCoversFloorOrCeiling) {
    Random random(32);
    for (int i = 0; i < 40; ++i) {
        const float a = random.real(0, 1);
        for (const std::uint64_t mask : written_masks(16, 10, a, random.integer(0, 5))) {
            ASSERT_GE(std::popcount(mask), static_cast<int>(std::floor(16 * a)));
            ASSERT_LE(std::popcount(mask), static_cast<int>(std::ceil(16 * a)));
        }
    }
}

TEST(AlphaReference, AlphaOneAlwaysPassesAlphaZeroNever) {
    for (const int surface : {0, 3}) {
        for (const std::uint64_t mask : written_masks(32, 64, 1.0f, surface)) ASSERT_EQ(mask, 0xFFFFFFFFu);
        for (const std::uint64_t mask : written_masks(32, 64, 0.0f, surface)) ASSERT_EQ(mask, 0u);
    }
}

// Figure 5: two layers of alpha 1/2 over 16 samples. Far to near as near to far, every pixel ends with
// exactly 8 near, 4 far and 4 background samples.
TEST(FigureFive, BothOrdersGiveFourFarSamplesInEveryPixel) {
    constexpr int kSide = 32;
    for (const bool near_first : {true, false}) {
        TestFrame frame("laine_karras:samples=16", test::header_of(kSide, kSide, 1, {0, 0, 1}));
        for (const bool near : {near_first, !near_first}) {
            std::vector<Fragment> layer;
            for (int i = 0; i < kSide * kSide; ++i)
                layer.push_back(
                    test::fragment_at(i % kSide, i / kSide, near ? 0.25f : 0.75f, 0.5f,
                                      near ? std::array<float, 3>{1, 0, 0} : std::array<float, 3>{0, 1, 0}));
            frame.draw(layer);
        }
        const auto image = frame.image();
        for (std::size_t i = 0; i < image.size(); i += 3) {
            ASSERT_EQ(image[i], 0.5f) << "near, near first: " << near_first;
            ASSERT_EQ(image[i + 1], 0.25f) << "far, near first: " << near_first;
            ASSERT_EQ(image[i + 2], 0.25f) << "background, near first: " << near_first;
        }
    }
}

// Figure 2's walk: triangles of one surface follow each other over a pixel of 4 samples until one meets a
// sample that is already covered. After each: the covered samples and the surface's number, as the tracking
// surface keeps them.
TEST(FigureTwo, SurfaceTracking) {
    struct Step {
        std::uint16_t coverage;
        float z;
        std::uint32_t covered;
        std::uint32_t surface;
    };
    const Step steps[] = {
        {0b0011, 0.50f, 0b0011, 0},  // first triangle
        {0b0100, 0.50f, 0b0111, 0},  // its neighbour on the same surface
        {0b1000, 0.50f, 0b1111, 0},  // the pixel is complete
        {0b0110, 0.40f, 0b0110, 1},  // two samples again: a new surface, which forgets the old one's coverage
        {0b1001, 0.40f, 0b1111, 1},  // the rest of it
        {0b1111, 0.60f, 0b1111, 1},  // behind opaque samples everywhere: not drawn, not tracked
        {0b0001, 0.40f, 0b0001, 2},  // equal depth passes, so it conflicts
        {0b0111, 0.30f, 0b0111, 3},  // one conflict of three is enough
        {0b1000, 0.45f, 0b0111, 3},  // hidden: no conflict, no coverage
        {0b1001, 0.35f, 0b1111, 3},  // sample 0 is covered but hides the fragment: sample 3 alone counts
    };
    TestFrame frame("laine_karras:samples=4", test::header_of(1, 1, 4));
    for (const Step& step : steps) {
        Fragment f = test::fragment_at(0, 0, step.z, 1.0f, {1, 1, 1});
        f.coverage = step.coverage;
        frame.draw_one(f);
        const auto words = frame.words(0, 0);
        const auto at = static_cast<std::size_t>(&step - steps);
        EXPECT_EQ(words[words.size() - 2], step.covered) << "step " << at;
        EXPECT_EQ(words[words.size() - 1], step.surface) << "step " << at;
    }
    EXPECT_EQ(frame.log().path_count(0), 2u) << "hidden";
}

TEST(Seed, ZeroIsThePaperAndOthersShiftThePixelIndex) {
    const auto header = test::header_of(20, 11);
    const auto zero = TestFrame::make("laine_karras", header, 0);
    const auto five = TestFrame::make("laine_karras", header, 5);
    const std::uint32_t offset = five->pixel_constant()(0, 0, glm::vec3(0.0f));
    EXPECT_NE(offset, 0u);
    for (int y = 0; y < header.height; ++y) {
        for (int x = 0; x < header.width; ++x) {
            ASSERT_EQ(zero->pixel_constant()(x, y, glm::vec3(0.0f)), hilbert_index(5, x, y));
            ASSERT_EQ(five->pixel_constant()(x, y, glm::vec3(0.0f)), hilbert_index(5, x, y) + offset);
        }
    }
}

TEST(Hilbert, VisitsEveryPixelOnceStepByStep) {
    for (int order = 0; order <= 7; ++order) {
        const int side = 1 << order;
        std::vector<std::pair<int, int>> place(static_cast<std::size_t>(side * side), {-1, -1});
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                const std::uint32_t index = hilbert_index(order, x, y);
                ASSERT_LT(index, place.size());
                ASSERT_EQ(place[index].first, -1) << "two pixels of index " << index;
                place[index] = {x, y};
            }
        }
        for (std::size_t i = 1; i < place.size(); ++i)
            ASSERT_EQ(std::abs(place[i].first - place[i - 1].first) +
                          std::abs(place[i].second - place[i - 1].second),
                      1)
                << "order " << order << " step " << i;
        EXPECT_EQ(place.front(), std::pair(0, 0));
        EXPECT_EQ(place.back(), std::pair(side - 1, 0));
    }
}

// Every aligned block of 4^k indices is a square of side 2^k: what makes neighbouring pixels share strata.
TEST(Hilbert, AlignedRunsAreSquares) {
    constexpr int kOrder = 5;
    for (int k = 1; k < kOrder; ++k) {
        std::map<std::uint32_t, std::set<std::pair<int, int>>> squares;
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x)
                squares[hilbert_index(kOrder, x, y) >> (2 * k)].insert({x >> k, y >> k});
        for (const auto& [run, corners] : squares) ASSERT_EQ(corners.size(), 1u);
    }
}

TEST(Hilbert, FirstPixelsAndOrders) {
    EXPECT_EQ(hilbert_index(1, 0, 0), 0u);
    EXPECT_EQ(hilbert_index(1, 0, 1), 1u);
    EXPECT_EQ(hilbert_index(1, 1, 1), 2u);
    EXPECT_EQ(hilbert_index(1, 1, 0), 3u);
    EXPECT_EQ(hilbert_index(2, 1, 0), 1u);  // order 2 begins to the right
    EXPECT_EQ(hilbert_index(2, 3, 0), 15u);
    EXPECT_EQ(hilbert_order(1, 1), 0);
    EXPECT_EQ(hilbert_order(2, 1), 1);
    EXPECT_EQ(hilbert_order(1280, 720), 11);
    EXPECT_EQ(hilbert_order(1024, 1024), 10);
}

}  // namespace
}  // namespace ropsim
