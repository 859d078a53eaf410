// What a fragment's mask depends on, by seed_from: Enderton et al. 2011, section 6, and the index that Salvi
// et al. 2011, section 4, give.
#include "rop/sampling/mask_table.h"
#include "tests/rop/mask_outcomes.h"

namespace ropsim {
namespace {

using test::TestFrame;

// Two draws of object 5, one of object 6.
TraceHeader three_draws(int side) {
    TraceHeader header = test::header_of(side, side, 1, {0, 0, 1});
    header.draws.resize(3);
    header.draws[0].object_id = 5;
    header.draws[1].object_id = 5;
    header.draws[2].object_id = 6;
    return header;
}

// The 32-sample mask one fragment takes of an empty frame.
std::uint64_t mask_of(const std::string& seed_from, const Fragment& f, std::uint64_t seed = 1) {
    TestFrame frame("stochastic:samples=32,seed_from=" + seed_from, three_draws(16), seed);
    frame.draw_one(f);
    return frame.log().record_access(0)[0].write;
}

// Each way with what must change the mask and what must not.
TEST(Seed, DependsOnWhatItIsTakenFromAlone) {
    const Fragment f = test::fragment_at(3, 4, 0.5f, 0.5f, {1, 1, 1}, 17);
    Fragment deeper = f;
    deeper.z = std::nextafter(f.z, 1.0f);
    Fragment primitive = f;
    primitive.primitive = 18;
    Fragment sibling = f;
    sibling.draw = 1;
    Fragment other = f;
    other.draw = 2;
    Fragment back = f;
    back.primitive |= kBackFacing;
    Fragment right = f;
    right.x = 4;
    Fragment below = f;
    below.y = 5;
    struct Case {
        const char* seed_from;
        std::vector<Fragment> same;
        std::vector<Fragment> different;
    };
    for (const Case& c : {Case{"primitive", {deeper, back}, {primitive, sibling, other}},
                          Case{"depth", {primitive, sibling, other, back}, {deeper}},
                          Case{"object", {deeper, primitive, sibling, back}, {other}},
                          Case{"object_facing", {deeper, primitive, sibling}, {other, back}}}) {
        const std::uint64_t mask = mask_of(c.seed_from, f);
        EXPECT_EQ(std::popcount(mask), 16);
        for (std::size_t i = 0; i < c.same.size(); ++i)
            EXPECT_EQ(mask_of(c.seed_from, c.same[i]), mask) << c.seed_from << " " << i;
        for (std::size_t i = 0; i < c.different.size(); ++i)
            EXPECT_NE(mask_of(c.seed_from, c.different[i]), mask) << c.seed_from << " " << i;
        // All include pixel and seed.
        EXPECT_NE(mask_of(c.seed_from, right), mask) << c.seed_from;
        EXPECT_NE(mask_of(c.seed_from, below), mask) << c.seed_from;
        EXPECT_NE(mask_of(c.seed_from, f, 2), mask) << c.seed_from;
    }
}

// "These fragments' masks will be identical, and they will occlude each other rather than blend": red before
// green over blue, alpha 1/2, of one object. Facing apart they are independent.
TEST(Seed, LayersOfAnObjectHideEachOther) {
    Fragment near = test::fragment_at(0, 0, 0.3f, 0.5f, {1, 0, 0}, 0);
    Fragment far = test::fragment_at(0, 0, 0.6f, 0.5f, {0, 1, 0}, 1);
    const auto green = [&](const std::string& seed_from) {
        const TraceHeader header = three_draws(128);
        const auto image = test::image_of("stochastic:samples=8,format=float32,seed_from=" + seed_from,
                                          header, test::everywhere(header, {far, near}));
        for (std::size_t i = 0; i < image.size(); i += 3) EXPECT_EQ(image[i], 0.5f);
        return test::moments_of(image, 1);
    };
    // Of green's 4 samples as many stay as red leaves: hypergeometric, mean 2, variance 4/7.
    const double error = 4 * std::sqrt(4.0 / 7) / 8 / 128;
    EXPECT_EQ(green("object").mean, 0);
    EXPECT_EQ(green("object_facing").mean, 0);
    EXPECT_NEAR(green("primitive").mean, 0.25, error);
    EXPECT_NEAR(green("depth").mean, 0.25, error);
    far.primitive |= kBackFacing;
    EXPECT_EQ(green("object").mean, 0);
    EXPECT_NEAR(green("object_facing").mean, 0.25, error);
    far.draw = 2;  // another object
    EXPECT_NEAR(green("object").mean, 0.25, error);
}

// Without a table of objects draws are objects.
TEST(Seed, DrawsAreObjectsWhereTheTraceNamesNone) {
    const auto mask = [](std::uint16_t draw) {
        TestFrame frame("stochastic:samples=32,seed_from=object", test::header_of(8, 8), 1);
        Fragment f = test::fragment_at(1, 1, 0.5f, 0.5f, {1, 1, 1});
        f.draw = draw;
        frame.draw_one(f);
        return frame.log().record_access(0)[0].write;
    };
    EXPECT_NE(mask(0), mask(1));
}

// Salvi et al. 2011, section 4: entry (primitive + x^2 + y) modulo 2,047, literally. A run's seed goes on in
// the table.
TEST(Seed, PatternIsThePublishedIndex) {
    constexpr int kSamples = 16;
    const MaskTable table(kSamples);
    test::Random random(71);
    for (int i = 0; i < 300; ++i) {
        const int x = random.integer(0, 299);
        const int y = random.integer(0, 299);
        const auto primitive = static_cast<std::uint32_t>(random.integer(0, 100000));
        const auto seed = static_cast<std::uint64_t>(random.integer(0, 3000));
        const float alpha = random.real(0.1, 1);
        TestFrame frame("stochastic:masks=table,seed_from=pattern,samples=16", test::header_of(300, 300),
                        i % 2 == 0 ? 0 : seed);
        Fragment f = test::fragment_at(x, y, 0.5f, alpha, {1, 1, 1}, primitive);
        if (i % 3 == 0) f.primitive |= kBackFacing;
        frame.draw_one(f);
        const std::uint64_t entry =
            (primitive + static_cast<std::uint64_t>(x) * static_cast<std::uint64_t>(x) +
             static_cast<std::uint64_t>(y) + (i % 2 == 0 ? 0 : seed)) %
            2047;
        EXPECT_EQ(frame.log().record_access(0)[0].write,
                  table.mask(static_cast<std::uint32_t>(entry), MaskTable::level(alpha)));
    }
}

// What the literal index costs: fragments of one pixel whose primitives are 2,047 apart, and neighbours in a
// column, share entries.
TEST(Seed, PatternRepeats) {
    const auto mask = [](int y, std::uint32_t primitive) {
        TestFrame frame("stochastic:masks=table,seed_from=pattern,samples=32", test::header_of(8, 8));
        frame.draw_one(test::fragment_at(2, y, 0.5f, 0.5f, {1, 1, 1}, primitive));
        return frame.log().record_access(0)[0].write;
    };
    EXPECT_EQ(mask(1, 10 + 2047), mask(1, 10));
    EXPECT_EQ(mask(2, 9), mask(1, 10));
    EXPECT_NE(mask(1, 11), mask(1, 10));
}

}  // namespace
}  // namespace ropsim
