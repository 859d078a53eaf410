// Units, latencies, storage and bytes against counts made by hand from the operations' definitions, written
// out here.
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::TestFrame;

// Latencies by short names, for the formulas below.
struct Shape {
    explicit Shape(const DatapathShape& s)
        : A(s.latency[static_cast<std::size_t>(Unit::kAdder)]),
          M(s.latency[static_cast<std::size_t>(Unit::kMultiplier)]),
          C(s.latency[static_cast<std::size_t>(Unit::kComparator)]),
          X(s.latency[static_cast<std::size_t>(Unit::kMux)]),
          L(s.latency[static_cast<std::size_t>(Unit::kLogic)]),
          V(s.latency[static_cast<std::size_t>(Unit::kConverter)]),
          I(s.latency[static_cast<std::size_t>(Unit::kIntegerAdder)]) {}
    int A, M, C, X, L, V, I;
};

UnitCounts counts(std::initializer_list<std::pair<Unit, std::uint32_t>> used) {
    UnitCounts units{};
    for (const auto& [unit, n] : used) units[static_cast<std::size_t>(unit)] = n;
    return units;
}

CostTable table_of(const std::string& technique, const DatapathShape& shape) {
    return TestFrame::make(technique, test::header_of(1, 1))->cost(shape);
}

const PathCost& path(const CostTable& table, const std::string& name) {
    const auto found = std::ranges::find(table, name, &PathCost::name);
    EXPECT_NE(found, table.end()) << name;
    return *found;
}

class HandCount : public testing::TestWithParam<DatapathShape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, HandCount, testing::Values(test::plain_shape(), test::prime_shape()),
                         [](const auto& setup) { return setup.index == 0 ? "Plain" : "Primes"; });

// out = source + (1 - alpha) * behind, in four channels:
//   1 adder for t = 1 - alpha, then 4 multipliers and 4 adders. Chain: adder, multiplier, adder.
TEST_P(HandCount, AlphaBlendInFloat32) {
    const Shape u(GetParam());
    const CostTable table = table_of("alpha_blend:format=float32", GetParam());
    ASSERT_EQ(table.size(), 1u);
    EXPECT_EQ(table[0].work.units, counts({{Unit::kAdder, 5}, {Unit::kMultiplier, 4}}));
    EXPECT_EQ(table[0].latency(), u.A + u.M + u.A);
}

// The same on binary16: 4 converters after the load and 4 before the store. The loads convert while 1 - alpha
// is computed, so the slower of the two counts.
TEST_P(HandCount, AlphaBlendInFloat16) {
    const Shape u(GetParam());
    const CostTable table = table_of("alpha_blend", GetParam());
    EXPECT_EQ(table[0].work.units,
              counts({{Unit::kAdder, 5}, {Unit::kMultiplier, 4}, {Unit::kConverter, 8}}));
    EXPECT_EQ(table[0].latency(), std::max(u.A, u.V) + u.M + u.A + u.V);
}

// Insertion into 8 float32 nodes, common to both paths:
//   t = 1 - alpha                                                       1 adder
//   nearer_i = z_i < z                                                  8 comparators
//   new depth of node 0: own or the fragment's                          1 mux
//   new depth of nodes 1..7: own, predecessor's or the fragment's       7 * 2 muxes
//   new depth of node 8: predecessor's or the fragment's                1 mux
//   product T_i * t of every old node                                   8 multipliers
//   new transmittance of nodes 0..7: own or a product (node 0: t)       8 muxes; node 8 takes the last
//   product is node 8 a real one?                                               1 comparator
// Sum: adder 1, multiplier 8, comparator 9, mux 24.
// Ready: depths at C + 2X (node 8: C + X), transmittances at max(A + M, C) + X (node 8: A + M), the question
// at C + X + C.
TEST_P(HandCount, AdaptiveInsert) {
    const Shape u(GetParam());
    const CostTable table = table_of("adaptive:nodes=8", GetParam());
    const PathCost& insert = path(table, "insert");
    EXPECT_EQ(insert.work.units,
              counts({{Unit::kAdder, 1}, {Unit::kMultiplier, 8}, {Unit::kComparator, 9}, {Unit::kMux, 24}}));
    EXPECT_EQ(insert.latency(), std::max({u.C + 2 * u.X, std::max(u.A + u.M, u.C) + u.X, u.C + u.X + u.C}));
}

// With compression, on top of the insertion:
//   e_j = (T_(j-1) - T_j) * (z_j - z_(j-1)), j = 1..8                   16 adders, 8 multipliers
//   smallest of 8 with its index: 7 comparisons, each moving the error and the index: 7 comparators, 14 muxes
//   does node i take its successor's transmittance (i >= removed - 1)   8 logic, one for each node 0..7
//   (that of i - 1 also says whether node i takes its successor's depth)
//   new depth of nodes 1..7, new transmittance of nodes 0..7            15 muxes
//   is node i written: behind the fragment or moved                     8 logic
// Sum with the insertion: adder 17, multiplier 16, comparator 16, mux 53, logic 16.
// Chain: the later of depth and transmittance, subtract, multiply, three rounds of compare and select,
// decode, then the mux of the value or the gate of the write mask.
TEST_P(HandCount, AdaptiveInsertCompress) {
    const Shape u(GetParam());
    const CostTable table = table_of("adaptive:nodes=8", GetParam());
    const PathCost& compress = path(table, "insert_compress");
    EXPECT_EQ(compress.work.units, counts({{Unit::kAdder, 17},
                                           {Unit::kMultiplier, 16},
                                           {Unit::kComparator, 16},
                                           {Unit::kMux, 53},
                                           {Unit::kLogic, 16}}));
    const int inserted = std::max(u.C + 2 * u.X, std::max(u.A + u.M, u.C) + u.X);
    EXPECT_EQ(compress.latency(), inserted + u.A + u.M + 3 * (u.C + u.X) + u.L + std::max(u.X, u.L));
}

// visibility: 8 comparators, 7 muxes in a tree of 3 levels and one for "nothing in front"; then 3 multipliers
// and 3 adders onto the accumulated binary16 colour: 3 converters in, 3 out.
TEST_P(HandCount, AdaptiveComposite) {
    const Shape u(GetParam());
    const CostTable table = table_of("adaptive:nodes=8", GetParam());
    const PathCost& composite = path(table, "composite");
    EXPECT_EQ(composite.pass, 1);
    EXPECT_EQ(composite.work.units, counts({{Unit::kAdder, 3},
                                            {Unit::kMultiplier, 3},
                                            {Unit::kComparator, 8},
                                            {Unit::kMux, 8},
                                            {Unit::kConverter, 6}}));
    EXPECT_EQ(composite.latency(), std::max(u.C + 4 * u.X + u.M, u.V) + u.A + u.V);
}

// accumulated + T_last * background: 3 converters, 3 multipliers, 3 adders.
TEST_P(HandCount, AdaptiveResolve) {
    const Shape u(GetParam());
    const CostTable table = table_of("adaptive:nodes=8", GetParam());
    const PathCost& resolve = path(table, "resolve");
    EXPECT_EQ(resolve.pass, kResolvePass);
    EXPECT_EQ(resolve.work.units, counts({{Unit::kAdder, 3}, {Unit::kMultiplier, 3}, {Unit::kConverter, 3}}));
    EXPECT_EQ(resolve.latency(), std::max(u.M, u.V) + u.A);
}

// Mean of S = 8 UNORM8 samples: 24 converters, 3 * 7 adders in a tree of 3 levels, 3 multipliers.
TEST_P(HandCount, StochasticResolve) {
    const Shape u(GetParam());
    const CostTable table = table_of("stochastic:samples=8", GetParam());
    const PathCost& resolve = path(table, "resolve");
    EXPECT_EQ(resolve.work.units,
              counts({{Unit::kAdder, 21}, {Unit::kMultiplier, 3}, {Unit::kConverter, 24}}));
    EXPECT_EQ(resolve.latency(), u.V + 3 * u.A + u.M);
}

// A list's resolve: outside the list only sum + T * background (3 multipliers, 3 adders). A node: 4
// converters of its UNORM8 colour, 1 - alpha, T * that, T * colour and the sum (4 adders, 4 multipliers). A
// comparison of the sort: one comparator and one mux. Appending: one adder hands out the node, one comparator
// asks whether there was one, and the colour converts to UNORM8.
TEST_P(HandCount, ABuffer) {
    const Shape u(GetParam());
    const CostTable table = table_of("a_buffer", GetParam());
    const PathCost& append = path(table, "append");
    EXPECT_EQ(append.work.units,
              counts({{Unit::kIntegerAdder, 1}, {Unit::kComparator, 1}, {Unit::kConverter, 4}}));
    EXPECT_EQ(append.latency(), std::max(u.I + u.C, u.V));
    const PathCost& overflow = path(table, "overflow");
    EXPECT_EQ(overflow.work.units, counts({{Unit::kIntegerAdder, 1}, {Unit::kComparator, 1}}));
    for (const SurfaceAccess& access : overflow.worst)
        EXPECT_EQ(access.write, 0u) << "a full pool writes nothing";
    const PathCost& resolve = path(table, "resolve");
    EXPECT_EQ(resolve.work.units, counts({{Unit::kAdder, 3}, {Unit::kMultiplier, 3}}));
    EXPECT_EQ(resolve.latency(), u.M + u.A);
    ASSERT_TRUE(resolve.has_step[0] && resolve.has_step[1]);
    EXPECT_EQ(resolve.step[0].units,
              counts({{Unit::kAdder, 4}, {Unit::kMultiplier, 4}, {Unit::kConverter, 4}}));
    EXPECT_EQ(resolve.step[0].latency, u.V + u.M + u.A);
    EXPECT_EQ(resolve.step[1].units, counts({{Unit::kComparator, 1}, {Unit::kMux, 1}}));
    EXPECT_EQ(resolve.step[1].latency, u.C + u.X);
    // 5 nodes and 8 comparisons one after the other.
    EXPECT_EQ(resolve.latency_cycles({5, 8}),
              static_cast<std::uint64_t>(resolve.latency() + 5 * (u.V + u.M + u.A) + 8 * (u.C + u.X)));
}

// A lane with 3 adders and 5 multipliers starts an alpha blend (5 adders, 4 multipliers) every second cycle,
// and an insertion with compression (17 adders, 16 multipliers) every sixth.
TEST(Interval, IsTheBusiestUnitOverItsBudget) {
    DatapathShape shape = test::plain_shape();
    EXPECT_EQ(table_of("adaptive:nodes=8", shape)[1].interval, 1) << "no budget: as many units as it needs";
    shape.budget[static_cast<std::size_t>(Unit::kAdder)] = 3;
    shape.budget[static_cast<std::size_t>(Unit::kMultiplier)] = 5;
    EXPECT_EQ(table_of("alpha_blend", shape)[0].interval, 2);
    EXPECT_EQ(table_of("adaptive:nodes=8", shape)[1].interval, 6);
    const CostTable list = table_of("a_buffer", shape);
    const PathCost& resolve = path(list, "resolve");
    EXPECT_EQ(resolve.interval, 1);
    EXPECT_EQ(resolve.step_interval, (std::array<int, 2>{2, 1}));
    EXPECT_EQ(resolve.interval_cycles({5, 8}), 1u + 5 * 2 + 8 * 1);
}

// Storage, and worst-case bytes a fragment over all passes: the papers' own model, no cache and no
// compression.
struct Claim {
    std::string technique;
    int bits_per_pixel;
    std::uint64_t read;
    std::uint64_t write;
};

class Bytes : public testing::TestWithParam<Claim> {};
INSTANTIATE_TEST_SUITE_P(Claims, Bytes,
                         testing::Values(Claim{"alpha_blend", 64, 8, 8},              // RGBA16F
                                         Claim{"stochastic:samples=4", 256, 16, 32},  // Z32F + RGBA8 a sample
                                         Claim{"stochastic:samples=8", 512, 32, 64},  //
                                         Claim{"stochastic:samples=16", 1024, 64, 128},  //
                                         Claim{"laine_karras:samples=8", 552, 37,
                                               69},  // + mask + 32-bit number
                                         Claim{"laine_karras:samples=16", 1072, 70, 134},   //
                                         Claim{"laine_karras:samples=64", 4192, 268, 524},  //
                                         Claim{"adaptive:nodes=4", 320, 72, 40},   // 8 bytes a node + RGBA16F
                                         Claim{"adaptive:nodes=8", 576, 136, 72},  //
                                         Claim{"adaptive:nodes=16", 1088, 264, 136},  //
                                         Claim{"slab:layers=4", 256, 32, 32},         // Z32F + RGBA8 a layer
                                         Claim{"slab:layers=8", 512, 64, 64},         //
                                         Claim{"slab:layers=8,bits=inf", 512, 64, 64},  //
                                         Claim{"weighted_blended", 72, 9, 9},           // RGBA16F + R8
                                         Claim{"a_buffer", 32, 4, 16}),                 // head + 12-byte node
                         [](const auto& setup) {
                             std::string name = setup.param.technique;
                             std::ranges::replace_if(
                                 name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); },
                                 '_');
                             return name;
                         });

TEST_P(Bytes, StorageAndWorstCaseTraffic) {
    const auto operation = TestFrame::make(GetParam().technique, test::header_of(1, 1));
    const Declaration& declaration = operation->declaration();
    EXPECT_EQ(declaration.storage_bits_per_pixel(), GetParam().bits_per_pixel);
    std::uint64_t read = 0;
    std::uint64_t write = 0;
    const CostTable table = operation->cost(test::plain_shape());
    for (int pass = 0; pass < static_cast<int>(declaration.passes.size()); ++pass) {
        test::AccessBytes worst;
        for (const PathCost& cost : table) {
            if (cost.pass != pass) continue;
            const auto bytes = test::bytes_of(declaration, cost.worst.data());
            worst.read = std::max(worst.read, bytes.read);
            worst.write = std::max(worst.write, bytes.write);
        }
        read += worst.read;
        write += worst.write;
    }
    EXPECT_EQ(read, GetParam().read);
    EXPECT_EQ(write, GetParam().write);
}

// The S-bit coverage mask and 32-bit surface number take whole bytes in memory, single bits in the claim.
TEST(ElementBytes, AreWhole) {
    const auto operation = TestFrame::make("laine_karras:samples=12", test::header_of(1, 1));
    const Surface& tracking = operation->declaration().surfaces[2];
    EXPECT_EQ(tracking.element_bits, 44);
    EXPECT_EQ(tracking.element_bytes(), 6);
}

}  // namespace
}  // namespace ropsim
