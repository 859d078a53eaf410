// Cutting: exactly what the options name is kept, bit for bit, and all else stays.
#include "traces/trace_cut.h"

#include "base/error.h"
#include "tests/traces/trace_conversion.h"
#include "traces/stress_traces.h"
#include "traces/trace_header.h"

#include <functional>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

class TraceCut : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        options_.width = 300;
        options_.height = 141;
        options_.samples = 4;
        options_.draws = 5;
        options_.opaque = options_.slopes = options_.materials = true;
        write_random(path("t"), options_);
        content_ = random_chunk(options_);
    }
    // Cuts, and expects those fragments of the whole trace that `keeps` says.
    void expect_cut(const CutOptions& cut, const std::function<bool(const Fragment&)>& keeps) {
        cut_trace(path("t"), path("cut"), cut);
        FragmentChunk expected;
        for (std::size_t i = 0; i < content_.size(); ++i) {
            if (!keeps(content_.fragments[i])) continue;
            expected.fragments.push_back(content_.fragments[i]);
            expected.slopes.push_back(content_.slopes[i]);
            expected.materials.push_back(content_.materials[i]);
        }
        EXPECT_FALSE(expected.empty());
        EXPECT_TRUE(same_content(read_raw(path("cut")), expected));
        const TraceReader before(path("t"));
        const TraceReader after(path("cut"));
        EXPECT_EQ(header_text(after.header(), 8), header_text(before.header(), 8));
        EXPECT_TRUE(same_bits(after.header().opaque->rgb, before.header().opaque->rgb));
    }
    std::string fault(const CutOptions& cut) {
        try {
            cut_trace(path("t"), path("cut"), cut);
        } catch (const UserError& error) {
            return error.where() + ": " + error.what();
        }
        return "(accepted)";
    }

    RandomFragments options_;
    FragmentChunk content_;
};

TEST_F(TraceCut, Regions) {
    const auto expect_region = [&](const std::string& text, int x, int y, int width, int height) {
        CutOptions cut;
        cut.region = parse_cut_region(text);
        expect_cut(cut, [=](const Fragment& f) {
            return f.x >= x && f.x < x + width && f.y >= y && f.y < y + height;
        });
    };
    expect_region("17,3,50x31", 17, 3, 50, 31);
    expect_region("0,0,300x141", 0, 0, 300, 141);
    expect_region("8,16,8x8", 8, 16, 8, 8);
    expect_region("290,130,10x11", 290, 130, 10, 11);
}

TEST_F(TraceCut, Draws) {
    const auto expect_draws = [&](const std::string& list, const std::set<int>& draws) {
        CutOptions cut;
        cut.draws = list;
        expect_cut(cut, [&](const Fragment& f) { return draws.contains(f.draw); });
    };
    expect_draws("3", {3});
    expect_draws("0,2-4", {0, 2, 3, 4});
    const std::string name = TraceReader(path("t")).header().draws[1].name;
    expect_draws(name + ",4", {1, 4});
}

TEST_F(TraceCut, FirstAndAllTogether) {
    CutOptions cut;
    cut.region = CutRegion{10, 10, 200, 100};
    cut.draws = "1,2";
    cut.first = 700;
    int left = 700;
    expect_cut(cut, [&](const Fragment& f) {
        const bool inside = f.x >= 10 && f.x < 210 && f.y >= 10 && f.y < 110 && (f.draw == 1 || f.draw == 2);
        return inside && left-- > 0;
    });
    cut = {};
    cut.first = 1;
    left = 1;
    expect_cut(cut, [&](const Fragment&) { return left-- > 0; });
}

// One tile in n, every column of tiles and every row of them among those.
TEST_F(TraceCut, EveryNthTileIsSpreadEvenly) {
    for (const int n : {1, 2, 3, 5, 7, 16}) {
        CutOptions cut;
        cut.every_nth_tile = n;
        cut_trace(path("t"), path("cut"), cut);
        TraceReader whole(path("t"));
        TraceReader part(path("cut"));
        std::size_t kept = 0;
        std::set<std::size_t> columns, rows;
        for (std::size_t tile = 0; tile < whole.tile_fragments().size(); ++tile) {
            if (part.tile_fragments()[tile] == 0) continue;
            EXPECT_EQ(part.tile_fragments()[tile], whole.tile_fragments()[tile]);
            ++kept;
            columns.insert(tile % 38);
            rows.insert(tile / 38);
        }
        EXPECT_NEAR(static_cast<double>(kept), 38.0 * 18 / n, 20) << n;
        EXPECT_EQ(columns.size(), 38u) << n;
        EXPECT_EQ(rows.size(), 18u) << n;
    }
}

TEST_F(TraceCut, ValuesStayAsStored) {
    write_stress_trace("non_finite", path("t"));
    cut_trace(path("t"), path("cut"), {});
    EXPECT_EQ(hash_of(path("cut")), hash_of(path("t")));
}

TEST_F(TraceCut, OptionsThatDoNotFitAreRefused) {
    CutOptions cut;
    cut.region = CutRegion{200, 0, 101, 5};
    EXPECT_THAT(fault(cut), HasSubstr("--region: 200,0,101x5 does not lie inside the 300x141 pixels"));
    cut.region = CutRegion{0, 0, 0, 5};
    EXPECT_THAT(fault(cut), HasSubstr("--region"));
    cut = {};
    cut.draws = "5";
    EXPECT_THAT(fault(cut), HasSubstr("--draws: '5': the trace has draws 0 to 4"));
    cut.draws = "3-1";
    EXPECT_THAT(fault(cut), HasSubstr("--draws: '3-1'"));
    cut.draws = "glass";
    EXPECT_THAT(fault(cut), HasSubstr("--draws: 'glass' is neither"));
    for (const char* text : {"", "1,2,3", "1,2,3x", "a,2,3x4", "1,2,3x4 ", "1;2;3x4"})
        EXPECT_THROW(parse_cut_region(text), UserError) << text;
    EXPECT_EQ(entries(), 1u);
}

}  // namespace
}  // namespace ropsim
