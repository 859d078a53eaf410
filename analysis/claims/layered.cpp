// Claims of Wyman 2016, "Stochastic Layered Alpha Blending": its probabilities, its memory and its cost.
#include "analysis/claims/declared_cost.h"
#include "analysis/claims/list.h"
#include "analysis/claims/mask_enumeration.h"
#include "rop/nodes/insertion_probability.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Wyman 2016";
constexpr const char* kProbabilities = "P of the operation's table against a count of all masks";

using Values = std::vector<double>;

struct Counts {
    int bits, front, own;
};
constexpr Counts kCounts[] = {{4, 2, 2}, {8, 4, 2}, {8, 6, 3}, {16, 12, 4}, {16, 8, 8}};

// The probability that a mask of the fragment is not inside the first `front` bits.
double counted(MaskDraw draw, const Counts& c) {
    const std::vector<double> masks = mask_probabilities(draw, c.bits, static_cast<double>(c.own) / c.bits);
    const std::uint32_t covered = (1u << c.front) - 1;
    double seen = 0;
    for (std::uint32_t mask = 0; mask < masks.size(); ++mask)
        if ((mask & ~covered) != 0) seen += masks[mask];
    return seen;
}

Finding probabilities(CoverageBits kind, MaskDraw draw) {
    Values ours;
    ClaimTable table{{"b", "s", "t", "equation", "counted"}, {}};
    double off = 0;
    for (const Counts& c : kCounts) {
        const double p = static_cast<double>(
            InsertionProbability(c.bits, kind)
                .at(static_cast<std::uint32_t>(c.front), static_cast<std::uint32_t>(c.own)));
        const double count = counted(draw, c);
        ours.push_back(p);
        off = std::max(off, std::abs(p - count));
        table.rows.push_back({std::to_string(c.bits), std::to_string(c.front), std::to_string(c.own),
                              fmt::format("{:.5f}", p), fmt::format("{:.5f}", count)});
    }
    return {{},
            ours,
            {{"", {}, off < 1e-6}},
            "b, s, t: 4 2 2, 8 4 2, 8 6 3, 16 12 4, 16 8 8; P_b behind coverage s for a fragment of t bits",
            table};
}

void add_probabilities(std::vector<Claim>& claims) {
    const auto add = [&](const char* id, const char* claim, const Printed& printed, const Rule& rule,
                         auto find) {
        claims.push_back({id, kPaper, "section 2.1", claim, printed, rule, Basis::kDefinition, kProbabilities,
                          false, [find](ClaimRuns&) { return find(); }});
    };
    add("slab-p-stratified", "Equation 1 is the probability of being visible with b stratified samples",
        Printed::statement("1 - (s)_t/(b)_t"), rule::statement(),
        [] { return probabilities(CoverageBits::kStratified, MaskDraw::kChoose); });
    add("slab-p-non-stratified", "Its other form is that of b non-stratified samples",
        Printed::statement("1 - ((b-t)/b)^(b-s)"), rule::statement(),
        [] { return probabilities(CoverageBits::kNonStratified, MaskDraw::kCoin); });
    add("slab-p-limit", "With more coverage bits P_b goes to 1", Printed::meaning("P_b -> 1", 1, 0.005),
        rule::digits(), [] {
            const auto at = [](int bits, int tenths) {
                return static_cast<double>(InsertionProbability(bits, CoverageBits::kStratified)
                                               .at(static_cast<std::uint32_t>(bits * tenths / 10),
                                                   static_cast<std::uint32_t>(bits / 10)));
            };
            Values values;
            for (const int bits : {10, 40, 160, 640}) values.push_back(at(bits, 9));
            return Finding{
                {},
                values,
                {{"", {std::min(at(640, 10), values.back())}},
                 {"layers in front that leave something visible", {values.back()}}},
                "alpha .1 behind .9 with 10, 40, 160, 640 bits; behind full coverage P is 0 for every b"};
        });
}

// Two layers of alpha .5 and 4 bits in both orders: the fragments that are inserted.
void add_discards(std::vector<Claim>& claims) {
    claims.push_back(
        {"slab-same-discards", kPaper, "section 2",
         "The far layer of two is kept as often as by stochastic transparency",
         Printed::formula("identical to stochastic transparency's",
                          {two_masks_cover(4, 2, 3, 4), two_masks_cover(4, 2, 3, 4)}),
         rule::exact(), Basis::kDefinition,
         "two layers of alpha .5, 4 samples or bits: insertions counted in runs", true, [](ClaimRuns& runs) {
             const auto kept = [&](const char* order) {
                 ClaimTrace trace{"black_before_white", "128x128", "64x64"};
                 trace.layers = 2;
                 trace.alpha = 0.5;
                 trace.order = order;
                 const RunRecord& run = runs.run({trace, "slab:layers=4,bits=4"});
                 double inserted = NAN;
                 for (const RecordedPath& path : run.paths)
                     if (path.path == "insert") inserted = number_of(path.count);
                 const double pixels = number_of(run.width) * number_of(run.height);
                 return std::pair(inserted / pixels - 1, 4 * std::sqrt(5.0 / 36 / pixels));
             };
             const auto [near, noise] = kept("near_to_far");
             const auto [far, same] = kept("far_to_near");
             const double exact = two_masks_cover(4, 2, 3, 4);
             return Finding{
                 {},
                 {near, far},
                 {{"", {near, far}, false, noise},
                  {"layers that arrive near to far", {near, exact}, false, noise}},
                 "near to far, then far to near: an insertion does not test again what is behind it"};
         }});
}

void add_memory(std::vector<Claim>& claims) {
    constexpr const char* kHow =
        "bits and worst-case bytes that the techniques declare, 8 layers over 8 samples";
    const auto ratios = [](auto of) {
        const double normalised = of(declared_cost("slab:layers=8,composite=normalised")) /
                                  of(declared_cost("stochastic:samples=8,method=depth_based"));
        const double one_pass =
            of(declared_cost("slab:layers=8")) / of(declared_cost("stochastic:samples=8"));
        return std::pair(normalised, one_pass);
    };
    claims.push_back(
        {"slab-8x-memory", kPaper, "abstract", "Roughly the memory of 8x stochastic samples",
         Printed::meaning("roughly", 1, 0.5), rule::about(), Basis::kDefinition, kHow, false,
         [=](ClaimRuns&) {
             const auto [normalised, one_pass] =
                 ratios([](const DeclaredCost& c) { return static_cast<double>(c.storage_bits); });
             const auto bits = [](const char* technique) { return declared_cost(technique).storage_bits; };
             return Finding{{normalised, one_pass},
                            {},
                            {{"", {normalised}}, {"one pass each", {one_pass}}},
                            fmt::format("{} bits over {} with the normalising passes that his results use, "
                                        "{} over {} in one pass; \"roughly 1\" taken as .5 to 1.5",
                                        bits("slab:layers=8,composite=normalised"),
                                        bits("stochastic:samples=8,method=depth_based"),
                                        bits("slab:layers=8"), bits("stochastic:samples=8"))};
         }});
    claims.push_back(
        {"slab-8x-cost", kPaper, "abstract", "Roughly the cost of 8x stochastic samples",
         Printed::meaning("roughly", 1, 0.5), rule::about(), Basis::kDefinition, kHow, true,
         [=](ClaimRuns& runs) {
             const auto [normalised, one_pass] = ratios([](const DeclaredCost& c) { return c.bytes(); });
             const auto pins = [&](const char* technique) {
                 const RunRecord& run = runs.run({{"forest", "1280x720", "160x90"}, technique, "cached"});
                 return number_of(run.total.pin_read) + number_of(run.total.pin_write);
             };
             const double measured =
                 pins("slab:layers=8,composite=normalised") / pins("stochastic:samples=8,method=depth_based");
             const double measured_one = pins("slab:layers=8") / pins("stochastic:samples=8");
             return Finding{
                 {normalised, one_pass},
                 {measured, measured_one},
                 {{"", {normalised}}, {"one pass each", {one_pass}}},
                 "bytes of a fragment at worst, on the pins of our scene forest; normalised, then in one "
                 "pass. His own times are 4.3 ms over 2.5"};
         }});
    claims.push_back({"slab-smaller", kPaper, "abstract", "A smaller footprint than 32 stochastic samples",
                      Printed::statement("the smaller memory footprint of k-buffers"), rule::statement(),
                      Basis::kDefinition, "bits a pixel that the techniques declare", false, [](ClaimRuns&) {
                          const double layered =
                              declared_cost("slab:layers=8,composite=normalised").storage_bits;
                          const double samples =
                              declared_cost("stochastic:samples=32,method=depth_based").storage_bits;
                          return Finding{{layered, samples},
                                         {},
                                         {{"", {}, layered < samples}},
                                         "8 layers and 32 samples, both normalised"};
                      }});
    claims.push_back(
        {"slab-k-buffer-cost", kPaper, "section 3", "SLAB and the k-buffer have identical performance",
         Printed::formula("identical performance", {1}), rule::exact(), Basis::kDefinition,
         "worst-case bytes of bits=inf over bits=16, and bytes on the pins", true, [](ClaimRuns& runs) {
             const double worst = declared_cost("slab:layers=8,bits=inf,composite=normalised").bytes() /
                                  declared_cost("slab:layers=8,bits=16,composite=normalised").bytes();
             const auto pins = [&](const char* technique) {
                 const RunRecord& run = runs.run({{"forest", "1280x720", "160x90"}, technique, "cached"});
                 return number_of(run.total.pin_read) + number_of(run.total.pin_write);
             };
             const double measured = pins("slab:layers=8,bits=inf,composite=normalised") /
                                     pins("slab:layers=8,composite=normalised");
             return Finding{
                 {worst},
                 {measured},
                 {{"", {measured}}, {"the worst case, in which every fragment is inserted", {worst}}},
                 "the same code path moves more where more is inserted"};
         }});
}

// Layers that 16 samples keep of endless ones of alpha .5: states are samples still free.
double layers_kept() {
    constexpr int kSamples = 16;
    Values of_free(kSamples + 1, 0.0);  // expected layers yet to come
    for (int free = 1; free <= kSamples; ++free) {
        double expected = 0;
        double none = 0;
        for (int taken = 0; taken <= std::min(free, kSamples / 2); ++taken) {
            const double p = binomial(free, taken) * binomial(kSamples - free, kSamples / 2 - taken) /
                             binomial(kSamples, kSamples / 2);
            if (taken == 0)
                none = p;
            else
                expected += p * (1 + of_free[static_cast<std::size_t>(free - taken)]);
        }
        of_free[static_cast<std::size_t>(free)] = expected / (1 - none);
    }
    return of_free[kSamples];
}

void add_figure2(std::vector<Claim>& claims) {
    claims.push_back(
        {"slab-four-layers", kPaper, "section 2",
         "16 samples hold not 16 but 4 layers where the nearest have alpha .5",
         Printed::meaning("limited to 4 layers", 4, 0.5), rule::digits(), Basis::kAssets,
         "expected number of layers stored of endless ones, by enumeration; Figure 2's pixel is not at hand",
         false, [](ClaimRuns&) {
             return Finding{
                 {},
                 {layers_kept()},
                 // The sentence is about the one pixel of the figure: nothing of ours is it.
                 {{"Figure 2's pixel", {std::numeric_limits<double>::quiet_NaN()}}},
                 fmt::format("not judged: the sentence is about the pixel that Figure 2 shows. The "
                             "three nearest leave {:g} of 16 samples on average, for one or two "
                             "layers more",
                             16 * std::pow(0.5, 3))};
         }});
}

}  // namespace

void add_layered_claims(std::vector<Claim>& claims) {
    add_probabilities(claims);
    add_discards(claims);
    add_memory(claims);
    add_figure2(claims);
    add_layered_quality_claims(claims);
}

}  // namespace ropsim
