// What the image and the state of every technique must fulfil, whatever it computes.
#include "tests/rop/technique_cases.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// With its parameters: Setup. By name only: Rule.
class Setup : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, Setup, testing::ValuesIn(test::technique_texts()), test::test_name);
class Rule : public testing::TestWithParam<std::string> {
 protected:
    std::string with(const std::string& parameters) const { return GetParam() + ":" + parameters; }
};
INSTANTIATE_TEST_SUITE_P(All, Rule, testing::ValuesIn(test::technique_names()), test::test_name);

// What the technique is for: its image or, where that is no colour, the state that it leaves (depths; a
// finite number stands for infinity).
std::vector<float> outcome(TestFrame& frame) {
    if (frame.declaration().image_is_color) return frame.image();
    std::vector<float> values;
    for (int y = 0; y < frame.header().height; ++y)
        for (int x = 0; x < frame.header().width; ++x)
            for (const std::uint32_t word : frame.words(x, y))
                values.push_back(std::min(std::bit_cast<float>(word), 2.0f));
    return values;
}

// Every word of the state survives its format unchanged: before the first fragment, and after any number.
TEST_P(Setup, StateHoldsOnlyStorableValues) {
    Random random(13);
    const TraceHeader header = test::opaque_header(8, 8, 1, random);
    test::FragmentOptions options;
    options.count = 2000;
    const auto fragments = test::random_fragments(header, options, random);
    TestFrame frame(GetParam(), header, 1);
    const auto check = [](const Surface& s, const std::uint32_t* words) {
        if (s.word_formats[0] == Format::kR11G11B10 || s.word_formats[0] == Format::kRgb9e5) {
            // The packed formats have surfaces of their own.
            for (int e = 0; e < s.elements; ++e) {
                const std::uint32_t* at = words + std::ptrdiff_t{e} * s.first_channels;
                const std::array<float, 3> rgb = {std::bit_cast<float>(at[0]), std::bit_cast<float>(at[1]),
                                                  std::bit_cast<float>(at[2])};
                ASSERT_EQ(stored_rgb(s.word_formats[0], rgb), rgb) << s.name;
            }
            return;
        }
        for (std::size_t w = 0; w < static_cast<std::size_t>(s.words); ++w) {
            const Format format = s.word_formats[w];
            if (format == Format::kBits || format == Format::kUint32) continue;
            const float value = std::bit_cast<float>(words[w]);
            ASSERT_EQ(std::bit_cast<std::uint32_t>(stored_value(format, value)), words[w])
                << s.name << " word " << w << " holds " << value;
        }
    };
    const auto check_all = [&] {
        for (const Surface& s : frame.declaration().surfaces) {
            if (s.layout == Layout::kPool) {
                for (std::uint32_t n = 0; n < frame.store().pool()->used(); ++n)
                    ASSERT_NO_FATAL_FAILURE(check(s, frame.store().pool()->words(n) + s.first_word));
                continue;
            }
            for (int i = 0; i < kTilePixels; ++i)
                ASSERT_NO_FATAL_FAILURE(check(s, frame.words(i % 8, i / 8).data() + s.first_word));
        }
    };
    check_all();
    frame.draw(fragments);
    check_all();
}

TEST_P(Rule, EmptyPixelResolvesToTheBackground) {
    Random random(14);
    const TraceHeader header = test::opaque_header(11, 9, 1, random);
    TestFrame frame(with("format=float32"), header);
    if (!frame.declaration().image_is_color) GTEST_SKIP() << "declared to have no colour";
    const std::vector<float> image = frame.image();
    EXPECT_TRUE(std::ranges::equal(image, header.opaque->rgb));
}

TEST_P(Rule, OneOpaqueFragmentResolvesToItsColour) {
    TestFrame frame(with("format=float32"), test::header_of(2, 1), 5);
    if (!frame.declaration().image_is_color) GTEST_SKIP() << "declared to have no colour";
    const std::array<float, 3> color = {0.3f, 0.9f, 0.05f};
    frame.draw_one(test::fragment_at(0, 0, 0.5f, 1.0f, color));
    const auto got = frame.color();
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(got[c], color[c], 1e-6) << c;
    EXPECT_EQ(frame.color(1, 0), (std::array<float, 3>{0.25f, 0.5f, 0.125f})) << "the pixel beside it";
}

// zero_alpha_harmless promises that the fragment may be dropped before the operation: the image with all of
// them must equal the image with none, wherever they come in depth and arrival.
TEST_P(Setup, FragmentsOfZeroAlphaAndColourChangeNothing) {
    Random random(15);
    const TraceHeader header = test::opaque_header(8, 8, 1, random);
    test::FragmentOptions options;
    options.count = 1500;
    options.distinct_depths = true;
    const auto drawn = test::random_fragments(header, options, random);
    std::vector<Fragment> with_nothing;
    for (const Fragment& f : drawn) {
        Fragment nothing = f;
        nothing.r = nothing.g = nothing.b = nothing.a = 0;
        nothing.z = random.real(0, f.z);
        with_nothing.push_back(nothing);
        with_nothing.push_back(f);
    }
    TestFrame a(GetParam(), header, 2);
    if (!a.declaration().zero_alpha_harmless) GTEST_SKIP() << "declared not harmless";
    TestFrame b(GetParam(), header, 2);
    a.draw(drawn);
    b.draw(with_nothing);
    EXPECT_EQ(outcome(a), outcome(b));
}

TEST_P(Rule, AnyOrderGivesTheSameImage) {
    Random random(16);
    const TraceHeader header = test::opaque_header(8, 8, 1, random);
    test::FragmentOptions options;
    options.count = std::size_t{64} * 12;
    options.distinct_depths = true;
    auto fragments = test::random_fragments(header, options, random);
    TestFrame forwards(with("format=float32"), header, 2);
    if (forwards.declaration().ordering != Ordering::kAny) GTEST_SKIP() << "declared to need raster order";
    forwards.draw(fragments);
    const std::vector<float> expected = outcome(forwards);
    for (int round = 0; round < 4; ++round) {
        random.shuffle(fragments);
        TestFrame shuffled(with("format=float32"), header, 2);
        shuffled.draw(fragments);
        const std::vector<float> image = outcome(shuffled);
        // At most about 40 additions a pixel, each within half an ulp of the largest sum; a reconstruction
        // from moments makes more of it.
        const double gain = GetParam() == "moment_based" ? 30 : 1;
        for (std::size_t i = 0; i < image.size(); ++i)
            ASSERT_NEAR(image[i], expected[i], gain * 40 * 0x1p-23) << i;
    }
}

TEST_P(Rule, RandomMeansThatTheSeedChangesTheImage) {
    Random random(17);
    const TraceHeader header = test::header_of(16, 16);
    test::FragmentOptions options;
    options.count = std::size_t{256} * 12;
    const auto fragments = test::random_fragments(header, options, random);
    TestFrame a(GetParam(), header, 1);
    TestFrame same(GetParam(), header, 1);
    TestFrame other(GetParam(), header, 2);
    for (TestFrame* frame : {&a, &same, &other}) frame->draw(fragments);
    const auto image = outcome(a);
    EXPECT_EQ(image, outcome(same));
    EXPECT_EQ(image != outcome(other), a.declaration().random);
}

}  // namespace
}  // namespace ropsim
