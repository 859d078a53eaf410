// What every technique must fulfil, run over technique_list(): a new technique is tested without a new line
// here.
#include "base/error.h"
#include "tests/rop/random_fragments.h"

#include <regex>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// Every technique with its defaults, in both formats, and corners of parameters worth the walk.
std::vector<std::string> technique_texts() {
    std::vector<std::string> texts;
    for (const TechniqueInfo& t : technique_list())
        for (const char* format : {"paper", "float32"})
            texts.push_back(std::string(t.name) + ":format=" + format);
    for (const char* corner :
         {"adaptive:nodes=2", "adaptive:nodes=5,depth_format=unorm24,transmittance_format=unorm8",
          "adaptive:nodes=64", "slab:layers=3,bits=inf", "slab:layers=1,bits=1", "slab:layers=64,bits=inf",
          "slab:layers=5,bits=256", "slab:layers=4,depth_format=float16",
          "stochastic:samples=12,depth_format=unorm24", "stochastic:samples=32,color_format=rgb9e5",
          "laine_karras:samples=12,color_format=r11g11b10", "laine_karras:samples=64",
          "alpha_blend:color_format=rgb9e5", "weighted_blended:color_format=float32"})
        texts.push_back(corner);
    return texts;
}

std::vector<std::string> technique_names() {
    std::vector<std::string> names;
    for (const TechniqueInfo& t : technique_list()) names.emplace_back(t.name);
    return names;
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
    return std::regex_replace(info.param, std::regex("[^A-Za-z0-9]"), "_");
}

// With its parameters: Setup. By name only: Rule.
class Setup : public testing::TestWithParam<std::string> {};
class Rule : public testing::TestWithParam<std::string> {
 protected:
    std::string with(const std::string& parameters) const { return GetParam() + ":" + parameters; }
};
INSTANTIATE_TEST_SUITE_P(All, Setup, testing::ValuesIn(technique_texts()), test_name);
INSTANTIATE_TEST_SUITE_P(All, Rule, testing::ValuesIn(technique_names()), test_name);

void expect_equal_words(TestFrame& a, TestFrame& b, const std::string& when) {
    for (int y = 0; y < a.header().height; ++y)
        for (int x = 0; x < a.header().width; ++x)
            ASSERT_TRUE(std::ranges::equal(a.words(x, y), b.words(x, y)))
                << "pixel " << x << "," << y << " " << when;
    if (a.store().pool() == nullptr) return;
    ASSERT_EQ(a.store().pool()->used(), b.store().pool()->used());
    ASSERT_EQ(a.store().pool()->overflowed(), b.store().pool()->overflowed());
    for (std::uint32_t node = 0; node < a.store().pool()->used(); ++node)
        for (int w = 0; w < a.declaration().node_words; ++w)
            ASSERT_EQ(a.store().pool()->words(node)[w], b.store().pool()->words(node)[w]) << "node " << node;
}

void expect_within(const Declaration& declaration, const PixelAccess& access, const PathCost& cost) {
    for (std::size_t s = 0; s < declaration.surfaces.size(); ++s) {
        const Surface& surface = declaration.surfaces[s];
        if (surface.layout != Layout::kPool) {
            ASSERT_EQ(access[s].read & ~cost.worst[s].read, 0u)
                << cost.name << " reads more of " << surface.name;
            ASSERT_EQ(access[s].write & ~cost.worst[s].write, 0u)
                << cost.name << " writes more of " << surface.name;
        }
        ASSERT_LE(access_bytes(surface, access[s].read), access_bytes(surface, cost.worst[s].read))
            << surface.name;
        ASSERT_LE(access_bytes(surface, access[s].write), access_bytes(surface, cost.worst[s].write))
            << surface.name;
    }
}

// A charged operation against its path's entry, and its accesses against the worst case.
void expect_entry(const Declaration& declaration, const ChargedOutcome& outcome, const CostTable& table,
                  int pass) {
    const PathCost& entry = table.at(static_cast<std::size_t>(outcome.path));
    ASSERT_EQ(entry.pass, pass) << entry.name;
    ASSERT_EQ(outcome.work, entry.work) << entry.name;
    for (std::size_t k = 0; k < 2; ++k) {
        if (outcome.steps[k] == 0) continue;
        ASSERT_TRUE(entry.has_step[k]) << entry.name;
        ASSERT_EQ(outcome.step_work[k], entry.step[k]) << entry.name << " step " << k;
    }
    expect_within(declaration, outcome.access, entry);
}

void expect_record(const OperationLog& log, std::size_t i, const ChargedOutcome& outcome,
                   std::size_t surfaces) {
    ASSERT_EQ(static_cast<int>(log.record_path(i)), outcome.path);
    ASSERT_EQ(log.record_steps(i), outcome.steps);
    for (std::size_t s = 0; s < surfaces; ++s) {
        ASSERT_EQ(log.record_access(i)[s].read, outcome.access[s].read) << "surface " << s;
        ASSERT_EQ(log.record_access(i)[s].write, outcome.access[s].write) << "surface " << s;
    }
}

TEST_P(Setup, EveryDeclaredPathHasACost) {
    const auto header = test::header_of(4, 4);
    const auto operation = TestFrame::make(GetParam(), header);
    const Declaration& declaration = operation->declaration();
    for (DatapathShape shape : {test::plain_shape(), test::prime_shape()}) {
        shape.budget.fill(2);
        const CostTable table = operation->cost(shape);
        ASSERT_EQ(table.size(), declaration.paths.size());
        for (std::size_t p = 0; p < table.size(); ++p) {
            EXPECT_EQ(table[p].name, declaration.paths[p]);
            EXPECT_GE(table[p].latency(), 1) << table[p].name;
            EXPECT_GE(table[p].interval, 1) << table[p].name;
            const std::uint32_t busiest =
                *std::max_element(table[p].work.units.begin(), table[p].work.units.end());
            EXPECT_EQ(table[p].interval, std::max(1, (static_cast<int>(busiest) + 1) / 2)) << table[p].name;
            EXPECT_GE(table[p].pass, kResolvePass);
            EXPECT_LT(table[p].pass, static_cast<int>(declaration.passes.size()));
        }
    }
}

// 10^4 fragments, one in three batches, in each pass: charged and plain are the same operation.
TEST_P(Setup, ChargedEqualsPlainAndItsTableEntry) {
    Random random(11);
    const TraceHeader header = test::opaque_header(6, 5, 4, random);
    constexpr std::uint64_t kPool = 6000;  // less than the fragments: a list must see it overflow
    const auto fragments = test::random_fragments(header, {}, random);
    TestFrame plain(GetParam(), header, 3, kPool);
    TestFrame charged(GetParam(), header, 3, kPool);
    const DatapathShape shape = test::prime_shape();
    const CostTable table = charged.operation().cost(shape);
    const std::size_t surfaces = plain.declaration().surfaces.size();
    std::vector<std::uint64_t> taken(table.size(), 0);
    constexpr std::size_t kBatch = 500;
    for (int pass = 0; pass < plain.passes(); ++pass) {
        for (std::size_t at = 0; at < fragments.size(); at += kBatch) {
            plain.log().clear_records();
            plain.draw_pass(pass, std::span(fragments).subspan(at, kBatch));
            ASSERT_EQ(plain.log().records(), kBatch);
            for (std::size_t i = 0; i < kBatch; ++i) {
                const auto outcome =
                    charged.operation().charged_fragment(shape, pass, fragments[at + i], charged.store());
                ASSERT_NO_FATAL_FAILURE(expect_record(plain.log(), i, outcome, surfaces))
                    << "fragment " << at + i;
                ASSERT_NO_FATAL_FAILURE(expect_entry(plain.declaration(), outcome, table, pass))
                    << "fragment " << at + i;
                ++taken[static_cast<std::size_t>(outcome.path)];
            }
            ASSERT_NO_FATAL_FAILURE(
                expect_equal_words(plain, charged, "after fragment " + std::to_string(at)));
        }
    }
    // A path that no fragment takes has not been compared with anything.
    for (std::size_t p = 0; p < table.size(); ++p) {
        EXPECT_EQ(plain.log().path_count(p), taken[p]);
        EXPECT_EQ(taken[p] > 0, table[p].pass != kResolvePass) << table[p].name;
    }
}

TEST_P(Setup, ChargedResolveEqualsPlainAndItsTableEntry) {
    Random random(12);
    const TraceHeader header = test::opaque_header(9, 10, 2, random);
    test::FragmentOptions options;
    options.count = 3000;
    const auto fragments = test::random_fragments(header, options, random);
    TestFrame frame(GetParam(), header, 3);
    frame.draw(fragments);
    frame.log().clear_records();
    const std::vector<float> image = frame.image();
    const DatapathShape shape = test::prime_shape();
    const CostTable table = frame.operation().cost(shape);
    const bool resolves = frame.declaration().resolves;
    std::array<float, 3> rgb{};
    // Records follow tiles row by row, then pixels of the tile.
    std::size_t record = 0;
    for (int i = 0; i < 4 * kTilePixels; ++i) {
        const int x = i / kTilePixels % 2 * kTileSize + i % kTileSize;
        const int y = i / kTilePixels / 2 * kTileSize + i % kTilePixels / kTileSize;
        if (x >= header.width || y >= header.height) continue;
        const auto outcome = frame.operation().charged_resolve(shape, frame.store(), x, y, rgb.data());
        for (std::size_t c = 0; c < 3; ++c)
            ASSERT_EQ(rgb[c], image[static_cast<std::size_t>(3 * (y * header.width + x)) + c])
                << x << "," << y;
        if (!resolves) continue;
        ASSERT_NO_FATAL_FAILURE(expect_entry(frame.declaration(), outcome, table, kResolvePass));
        ASSERT_NO_FATAL_FAILURE(
            expect_record(frame.log(), record++, outcome, frame.declaration().surfaces.size()));
    }
    EXPECT_EQ(record, frame.log().records()) << "an image that is read where it lies is no operation";
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
            const std::array<float, 3> rgb = {std::bit_cast<float>(words[0]), std::bit_cast<float>(words[1]),
                                              std::bit_cast<float>(words[2])};
            ASSERT_EQ(stored_rgb(s.word_formats[0], rgb), rgb) << s.name;
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
                for (int e = 0; e < s.elements; ++e)
                    ASSERT_NO_FATAL_FAILURE(
                        check(s, frame.words(i % 8, i / 8).data() + s.first_word + e * s.words));
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
    const std::vector<float> image = frame.image();
    EXPECT_TRUE(std::ranges::equal(image, header.opaque->rgb));
}

TEST_P(Rule, OneOpaqueFragmentResolvesToItsColour) {
    TestFrame frame(with("format=float32"), test::header_of(2, 1), 5);
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
    EXPECT_EQ(a.image(), b.image());
}

TEST_P(Rule, AnyOrderGivesTheSameImage) {
    Random random(16);
    const TraceHeader header = test::opaque_header(8, 8, 1, random);
    test::FragmentOptions options;
    options.count = 64 * 12;
    options.distinct_depths = true;
    auto fragments = test::random_fragments(header, options, random);
    TestFrame forwards(with("format=float32"), header, 2);
    if (forwards.declaration().ordering != Ordering::kAny) GTEST_SKIP() << "declared to need raster order";
    forwards.draw(fragments);
    const std::vector<float> expected = forwards.image();
    for (int round = 0; round < 4; ++round) {
        random.shuffle(fragments);
        TestFrame shuffled(with("format=float32"), header, 2);
        shuffled.draw(fragments);
        const std::vector<float> image = shuffled.image();
        // At most about 40 additions a pixel, each within half an ulp of the largest sum.
        for (std::size_t i = 0; i < image.size(); ++i) ASSERT_NEAR(image[i], expected[i], 40 * 0x1p-23) << i;
    }
}

TEST_P(Rule, RandomMeansThatTheSeedChangesTheImage) {
    Random random(17);
    const TraceHeader header = test::header_of(16, 16);
    test::FragmentOptions options;
    options.count = 256 * 12;
    const auto fragments = test::random_fragments(header, options, random);
    TestFrame a(GetParam(), header, 1);
    TestFrame same(GetParam(), header, 1);
    TestFrame other(GetParam(), header, 2);
    for (TestFrame* frame : {&a, &same, &other}) frame->draw(fragments);
    const auto image = a.image();
    EXPECT_EQ(image, same.image());
    EXPECT_EQ(image != other.image(), a.declaration().random);
}

TEST_P(Rule, RefusesBadParameters) {
    const auto header = test::header_of(4, 4);
    for (const char* bad : {"nonsense=1", "format=banana", "format=", "image_format=float8", "=3", "format"})
        EXPECT_THROW(TestFrame::make(with(bad), header), UserError) << bad;
    EXPECT_THROW(TestFrame::make("x" + GetParam(), header), UserError);
}

// The ranges that `ropsim list techniques` prints are those in force.
TEST_P(Rule, DocumentedRangesHold) {
    const auto header = test::header_of(4, 4);
    const auto info = std::ranges::find(technique_list(), GetParam(), &TechniqueInfo::name);
    const std::string keys(info->keys);
    const std::regex range(R"((\w+)=[^,()]*\((\d+)\.\.(\d+))");
    for (std::sregex_iterator m(keys.begin(), keys.end(), range), end; m != end; ++m) {
        const std::string key = (*m)[1].str() + "=";
        const int low = std::stoi((*m)[2]);
        const int high = std::stoi((*m)[3]);
        EXPECT_NO_THROW(TestFrame::make(with(key + std::to_string(low)), header)) << key;
        EXPECT_NO_THROW(TestFrame::make(with(key + std::to_string(high)), header)) << key;
        for (const std::string& bad :
             {std::to_string(low - 1), std::to_string(high + 1), std::string("many"), std::string("-3")})
            EXPECT_THROW(TestFrame::make(with(key + bad), header), UserError) << key << bad;
    }
    const std::string headline = info->headline ? with(std::string(info->headline_parameters)) : GetParam();
    EXPECT_NO_THROW(TestFrame::make(headline, header));
}

TEST(StoredSamples, AreAMultipleOfTheTraces) {
    for (const char* name : {"stochastic", "laine_karras"}) {
        EXPECT_NO_THROW(TestFrame::make(std::string(name) + ":samples=12", test::header_of(4, 4, 4)));
        EXPECT_THROW(TestFrame::make(std::string(name) + ":samples=6", test::header_of(4, 4, 4)), UserError);
        EXPECT_THROW(TestFrame::make(name, test::header_of(4, 4, 16)), UserError) << "8 over 16";
    }
}

TEST(PackedFormats, AreRefusedWhereAlphaOrDepthIsKept) {
    const auto header = test::header_of(4, 4);
    for (const char* bad : {"slab:color_format=rgb9e5", "a_buffer:color_format=r11g11b10",
                            "adaptive:depth_format=rgb9e5", "weighted_blended:color_format=r11g11b10"})
        EXPECT_THROW(TestFrame::make(bad, header), UserError) << bad;
}

}  // namespace
}  // namespace ropsim
