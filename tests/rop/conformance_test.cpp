// Charged and plain datapath are one operation, and the cost table tells the truth, for every technique.
#include "tests/rop/technique_cases.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

class Conformance : public testing::TestWithParam<std::string> {
 protected:
    // As many spatial samples as the technique can take, up to `most`.
    static int spatial_samples(int most) {
        return TestFrame::make(GetParam(), test::header_of(1, 1))->declaration().uses_coverage ? most : 1;
    }
};
INSTANTIATE_TEST_SUITE_P(All, Conformance, testing::ValuesIn(test::technique_texts()), test::test_name);

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
        // Elements may change roles from round to round, as those of a ping-pong pair do.
        if (surface.layout != Layout::kPool && !surface.addressed && declaration.repeat.rounds == 1) {
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

TEST_P(Conformance, EveryDeclaredPathHasACost) {
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

// An image pass over the whole image, pixel by pixel, charged and plain.
void expect_equal_image_pass(TestFrame& plain, TestFrame& charged, const DatapathShape& shape,
                             const CostTable& table, const PassSequence& at,
                             std::vector<std::uint64_t>& taken) {
    plain.log().clear_records();
    plain.image_pass(at.pass(), at.round());
    const TraceHeader& header = plain.header();
    ASSERT_LE(header.width, kTileSize);
    ASSERT_LE(header.height, kTileSize);
    std::size_t record = 0;
    const int scale = at.current().scale;
    for (int y = 0; y < low_resolution(header.height, scale); ++y) {
        for (int x = 0; x < low_resolution(header.width, scale); ++x) {
            const auto outcome = charged.operation().charged_image_pass(
                shape, at.pass(), at.round(), charged.store(), charged.stores(), x, y);
            ASSERT_NO_FATAL_FAILURE(
                expect_record(plain.log(), record++, outcome, plain.declaration().surfaces.size()));
            ASSERT_NO_FATAL_FAILURE(expect_entry(plain.declaration(), outcome, table, at.pass()));
            ++taken[static_cast<std::size_t>(outcome.path)];
        }
    }
    ASSERT_NO_FATAL_FAILURE(expect_equal_words(plain, charged, "after an image pass"));
}

// Fragment by fragment in each pass, and image passes: charged and plain are the same operation. `taken`: how
// often each path was.
void expect_charged_is_plain(const std::string& technique, const TraceHeader& header,
                             const std::vector<Fragment>& fragments, Random& random,
                             std::vector<std::uint64_t>& taken) {
    constexpr std::uint64_t kPool = 6000;  // less than 10^4 fragments: a list must see it overflow
    std::vector<DepthSlope> slopes;
    for (std::size_t i = 0; i < fragments.size(); ++i)
        slopes.push_back({random.real(-0.02, 0.02), random.real(-0.02, 0.02)});
    const auto materials = test::random_materials(fragments.size(), random);
    TestFrame plain(technique, header, 3, kPool);
    TestFrame charged(technique, header, 3, kPool);
    const DatapathShape shape = test::prime_shape();
    const CostTable table = charged.operation().cost(shape);
    const std::size_t surfaces = plain.declaration().surfaces.size();
    taken.assign(table.size(), 0);
    constexpr std::size_t kBatch = 500;
    constexpr int kMostRounds = 4;  // of a technique that would go on until nothing is left
    PassSequence sequence(plain.declaration());
    while (!sequence.done() && sequence.round() < kMostRounds) {
        const int pass = sequence.pass();
        const int round = sequence.round();
        if (round > 0) {
            plain.store().restore(sequence.current().restores);
            charged.store().restore(sequence.current().restores);
        }
        if (sequence.current().kind == PassKind::kImage) {
            ASSERT_NO_FATAL_FAILURE(expect_equal_image_pass(plain, charged, shape, table, sequence, taken));
        }
        const auto drawn = test::at_resolution(fragments, header, sequence.current().scale);
        const std::size_t count = sequence.current().kind == PassKind::kImage ? 0 : fragments.size();
        for (std::size_t at = 0; at < count; at += kBatch) {
            plain.log().clear_records();
            plain.draw_pass(pass, std::span(drawn).subspan(at, kBatch), round,
                            std::span(slopes).subspan(at, kBatch), std::span(materials).subspan(at, kBatch));
            ASSERT_EQ(plain.log().records(), kBatch);
            for (std::size_t i = 0; i < kBatch; ++i) {
                const auto outcome = charged.operation().charged_fragment(
                    shape, pass, round, drawn[at + i], {slopes[at + i], materials[at + i]}, charged.store());
                ASSERT_NO_FATAL_FAILURE(expect_record(plain.log(), i, outcome, surfaces))
                    << "fragment " << at + i;
                ASSERT_NO_FATAL_FAILURE(expect_entry(plain.declaration(), outcome, table, pass))
                    << "fragment " << at + i;
                ++taken[static_cast<std::size_t>(outcome.path)];
            }
            ASSERT_NO_FATAL_FAILURE(
                expect_equal_words(plain, charged, "after fragment " + std::to_string(at)));
        }
        const int watched = sequence.watched_path();
        sequence.advance(watched < 0 ? 0 : taken[static_cast<std::size_t>(watched)]);
    }
    for (std::size_t p = 0; p < table.size(); ++p) EXPECT_EQ(plain.log().path_count(p), taken[p]);
}

// 10^4 fragments, one in three batches.
TEST_P(Conformance, ChargedEqualsPlainAndItsTableEntry) {
    Random random(11);
    const TraceHeader header = test::with_materials(test::opaque_header(6, 5, spatial_samples(4), random));
    const auto fragments = test::random_fragments(header, {}, random);
    std::vector<std::uint64_t> taken;
    ASSERT_NO_FATAL_FAILURE(expect_charged_is_plain(GetParam(), header, fragments, random, taken));
    // A path that no fragment takes has not been compared with anything.
    const CostTable table = TestFrame::make(GetParam(), header)->cost(test::prime_shape());
    for (std::size_t p = 0; p < table.size(); ++p)
        EXPECT_EQ(taken[p] > 0, table[p].pass != kResolvePass) << table[p].name;
}

// Fragments so bright that what binary16 sums ends at 65504; of one spatial sample, for
// which some techniques take a shortcut.
TEST_P(Conformance, ChargedEqualsPlainWhereSumsEnd) {
    Random random(13);
    // Wide enough for a sample of an eighth of the resolution.
    const TraceHeader header = test::with_materials(test::opaque_header(5, 5, 1, random));
    test::FragmentOptions options;
    options.count = 1500;
    auto fragments = test::random_fragments(header, options, random);
    for (Fragment& f : fragments) {
        f.r *= 2e5f;
        f.g *= 3e4f;
        f.b *= 1e3f;
    }
    std::vector<std::uint64_t> taken;
    ASSERT_NO_FATAL_FAILURE(expect_charged_is_plain(GetParam(), header, fragments, random, taken));
}

TEST_P(Conformance, ChargedResolveEqualsPlainAndItsTableEntry) {
    Random random(12);
    const TraceHeader header = test::with_materials(test::opaque_header(9, 10, spatial_samples(2), random));
    test::FragmentOptions options;
    options.count = 3000;
    const auto fragments = test::random_fragments(header, options, random);
    TestFrame frame(GetParam(), header, 3);
    frame.draw(fragments, {}, test::random_materials(fragments.size(), random));
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
        const auto outcome =
            frame.operation().charged_resolve(shape, frame.store(), frame.stores(), x, y, rgb.data());
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

}  // namespace
}  // namespace ropsim
