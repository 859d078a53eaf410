// A validation as a section of a page.
#include "analysis/validation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::HasSubstr;

ValidatedTechnique technique(const std::string& name, Format stored, std::uint64_t equal,
                             std::uint64_t within) {
    ValidatedTechnique t;
    t.technique = name;
    t.agreement.stored = stored;
    t.agreement.bound = agreement_bound(stored, 0);
    t.agreement.pixels = 1000000;
    t.agreement.equal = equal;
    t.agreement.within = within;
    t.agreement.worst_units = equal == 1000000 ? 0 : 2;
    return t;
}

TEST(ValidationMarkdown, SaysWhatAgreesAndWhatDoesNot) {
    Validation v;
    v.options.input = "scenes/motor";
    v.width = 192;
    v.height = 108;
    v.fragments = 100560;
    v.covered = 5020;
    v.drawn = "geometry";
    v.renderer = "a driver";
    v.techniques = {technique("all", Format::kFloat16, 1000000, 1000000),
                    technique("nearly", Format::kFloat16, 999999, 999999),
                    technique("wrong", Format::kUnorm8, 500000, 900000)};
    v.techniques.emplace_back();
    v.techniques.back().technique = "none";
    v.techniques.back().failure = "takes one sample a pixel";
    const std::string text = validation_markdown(v);
    for (const char* part :
         {"## motor\n", "192x108 pixels, 100,560 fragments", "Of 3 comparisons 2 are within their bounds",
          "| `all` | float16 | 0 | 100 | 100 | agrees | - |",
          "| `nearly` | float16 | 2 ulp | 99.9999 | 99.9999 | agrees |",
          "| `wrong` | unorm8 | 2 codes | 50 | 90 | **differs** |", "- `none`: takes one sample a pixel"})
        EXPECT_THAT(text, HasSubstr(part));
}

}  // namespace
}  // namespace ropsim
