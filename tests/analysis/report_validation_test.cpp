// A validation's page from a validation made by hand.
#include "analysis/report/report_validation.h"

#include "tests/traces/scratch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::HasSubstr;
using testing::Not;

std::size_t occurrences(const std::string& text, const std::string& what) {
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
    return count;
}

class ReportValidation : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        validation_.options.directory = path("");
        validation_.width = 8;
        validation_.height = 8;
        validation_.renderer = "<driver>";
    }
    // With an EXR of constant images, `off` apart.
    void add(const std::string& name, float off, std::uint64_t within) {
        ValidatedTechnique technique;
        technique.technique = name;
        technique.picture = "difference-" + name + ".png";
        technique.agreement.pixels = 64;
        technique.agreement.equal = technique.agreement.within = within;
        technique.agreement.bound.within_share = technique.agreement.bound.equal_share = 1;
        validation_.techniques.push_back(technique);
        Image model(8, 8, {"R", "G", "B"});
        std::fill(model.values.begin(), model.values.end(), 0.5f);
        Image drawn = model;
        for (float& value : drawn.values) value += off;
        write_exr(path("difference-" + name + ".exr"),
                  difference_channels(model, drawn, std::vector<PixelKind>(64, PixelKind::kSameFragments),
                                      Format::kFloat32));
    }
    Validation validation_;
};

TEST_F(ReportValidation, SaysWhoAgreesAndKeepsEqualPicturesOnce) {
    add("one", 0, 64);
    add("two", 0, 64);
    const std::string html = validation_report(validation_, "ropsim validate x");
    EXPECT_THAT(html, HasSubstr("<h2>All techniques agree</h2>"));
    EXPECT_EQ(occurrences(html, ">agrees</td>"), 2u);
    EXPECT_THAT(html, HasSubstr("100.0000"));
    EXPECT_EQ(occurrences(html, ">data:image/webp;base64,"), 2u) << "one image, one black difference";
    EXPECT_THAT(html, HasSubstr("&lt;driver&gt;"));
    EXPECT_THAT(html, HasSubstr("ropsim validate x"));
}

TEST_F(ReportValidation, SaysWhoDiffersAndWhere) {
    add("one", 0, 64);
    add("other", 0.25f, 0);
    validation_.techniques[1].first = DifferingPixel{3, 4, {0.5f, 0.5f, 0.5f}, {0.75f, 0.75f, 0.75f}, {}, {}};
    ValidatedTechnique refused;
    refused.technique = "third";
    refused.failure = "needs <more>";
    validation_.techniques.push_back(refused);
    const std::string html = validation_report(validation_, "");
    EXPECT_THAT(html, HasSubstr("<h2>Some techniques differ</h2>"));
    EXPECT_EQ(occurrences(html, ">agrees</td>"), 1u);
    EXPECT_EQ(occurrences(html, ">differs</td>"), 1u);
    EXPECT_THAT(html, HasSubstr("needs &lt;more&gt;"));
    EXPECT_THAT(html, HasSubstr("<td>3, 4</td><td>0.5 0.5 0.5</td><td>0.75 0.75 0.75</td>"));
    EXPECT_EQ(occurrences(html, ">data:image/webp;base64,"), 4u);
}

TEST_F(ReportValidation, SurvivesAMissingPicture) {
    add("one", 0, 64);
    std::filesystem::remove(path("difference-one.exr"));
    const std::string html = validation_report(validation_, "");
    EXPECT_THAT(html, HasSubstr("difference-one.exr"));
    EXPECT_THAT(html, Not(HasSubstr("data-widget=\"views\"")));
}

}  // namespace
}  // namespace ropsim
