// What every technique accepts and refuses as parameters, and that `ropsim list techniques` tells the truth
// about it.
#include "base/error.h"
#include "tests/rop/technique_cases.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::TestFrame;

class TechniqueParameters : public testing::TestWithParam<std::string> {
 protected:
    std::string with(const std::string& parameters) const { return GetParam() + ":" + parameters; }
    const TechniqueInfo& info() const {
        return *std::ranges::find(technique_list(), std::string_view(GetParam()), &TechniqueInfo::name);
    }
};
INSTANTIATE_TEST_SUITE_P(All, TechniqueParameters, testing::ValuesIn(test::technique_names()),
                         [](const auto& setup) { return setup.param; });

TEST_P(TechniqueParameters, RefusesBadParameters) {
    const auto header = test::header_of(4, 4);
    for (const char* bad : {"nonsense=1", "format=banana", "format=", "image_format=float8", "=3", "format"})
        EXPECT_THROW(TestFrame::make(with(bad), header), UserError) << bad;
    EXPECT_THROW(TestFrame::make("x" + GetParam(), header), UserError);
}

// A technique that ignores coverage would composite partly covered pixels as whole ones: it refuses such
// traces.
TEST_P(TechniqueParameters, TakesSpatialSamplesOnlyIfItUsesCoverage) {
    const bool uses_coverage =
        TestFrame::make(GetParam(), test::header_of(4, 4))->declaration().uses_coverage;
    if (uses_coverage)
        EXPECT_NO_THROW(TestFrame::make(GetParam(), test::header_of(4, 4, 4)));
    else
        EXPECT_THROW(TestFrame::make(GetParam(), test::header_of(4, 4, 4)), UserError);
}

// Every "key=DEFAULT (LOW..HIGH" of a technique's documented keys.
struct DocumentedRange {
    std::string key;
    int low, high;
};
std::vector<DocumentedRange> documented_ranges(std::string_view keys) {
    std::vector<DocumentedRange> ranges;
    for (std::size_t dots = keys.find(".."); dots != std::string_view::npos;
         dots = keys.find("..", dots + 1)) {
        const std::size_t bracket = keys.rfind('(', dots);
        const std::size_t equals = keys.rfind('=', bracket);
        const std::size_t space = keys.rfind(' ', equals);
        const std::size_t first = space == std::string_view::npos ? 0 : space + 1;
        ranges.push_back({std::string(keys.substr(first, equals - first)),
                          std::stoi(std::string(keys.substr(bracket + 1))),
                          std::stoi(std::string(keys.substr(dots + 2)))});
    }
    return ranges;
}

TEST(DocumentedRanges, AreFound) {
    const auto ranges =
        documented_ranges("layers=8 (1..64), bits=2*layers (3..256, or inf: the k-buffer end)");
    ASSERT_EQ(ranges.size(), 2u);
    EXPECT_EQ(ranges[0].key, "layers");
    EXPECT_EQ(ranges[1].key, "bits");
    EXPECT_EQ(ranges[1].low, 3);
    EXPECT_EQ(ranges[1].high, 256);
}

TEST_P(TechniqueParameters, DocumentedRangesHold) {
    const auto header = test::header_of(4, 4);
    for (const auto& [key, low, high] : documented_ranges(info().keys)) {
        for (const int good : {low, high})
            EXPECT_NO_THROW(TestFrame::make(with(key + "=" + std::to_string(good)), header)) << key << good;
        for (const std::string& bad :
             {std::to_string(low - 1), std::to_string(high + 1), std::string("many"), std::string("-3")})
            EXPECT_THROW(TestFrame::make(with(key + "=" + bad), header), UserError) << key << bad;
    }
    const std::string headline = info().headline ? with(std::string(info().headline_parameters)) : GetParam();
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
