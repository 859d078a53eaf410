// .hair files: files written here field by field, every truncation and flipped header bit.
#include "capture/files/hair_file.h"

#include "base/error.h"
#include "tests/capture/hair_bytes.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include <gmock/gmock.h>

namespace ropsim {
namespace {

using testing::Bytes;
using testing::bytes_of;
using testing::cylinder;
using testing::HairSpec;
using ::testing::HasSubstr;
using testing::kAll;

std::string refusal(const Bytes& bytes) {
    try {
        parse_hair(bytes, "a.hair");
    } catch (const UserError& error) {
        EXPECT_EQ(error.where(), "a.hair");
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        return error.what();
    }
    return "";
}

TEST(HairFileTest, EveryArrayIsRead) {
    const HairFile hair = parse_hair(bytes_of({}), "a.hair");
    EXPECT_EQ(hair.strands(), 2u);
    EXPECT_THAT(hair.first_points, ::testing::ElementsAre(0u, 2u, 5u));
    EXPECT_EQ(hair.points[4], glm::vec3(1, 0.5f, 2));
    EXPECT_THAT(hair.thickness, ::testing::ElementsAre(0.1f, 0.2f, 0.3f, 0.4f, 0.5f));
    EXPECT_THAT(hair.transparency, ::testing::ElementsAre(0, 0.25f, 0.5f, 0.75f, 1));
    EXPECT_EQ(hair.colors[1], glm::vec3(0, 1, 0));
    EXPECT_EQ(hair.colors[4], glm::vec3(0.25f, 0.5f, 0.75f));
    EXPECT_EQ(hair.info, "two strands");
}

TEST(HairFileTest, HeaderStandsInForAbsentArrays) {
    HairSpec spec;
    spec.flags = 2;
    spec.default_segments = 1;
    spec.points.resize(12);
    const HairFile hair = parse_hair(bytes_of(spec), "a.hair");
    EXPECT_THAT(hair.first_points, ::testing::ElementsAre(0u, 2u, 4u));
    EXPECT_THAT(hair.thickness, ::testing::Each(0.07f));
    EXPECT_THAT(hair.transparency, ::testing::Each(0.4f));
    EXPECT_THAT(hair.colors, ::testing::Each(glm::vec3(0.9f, 0.6f, 0.3f)));
    EXPECT_EQ(hair.thickness.size(), 4u);
}

TEST(HairFileTest, StrandsOfOnePointAreLeftOut) {
    HairSpec spec;
    spec.strands = 3;
    spec.segments = {1, 0, 1};
    const HairFile hair = parse_hair(bytes_of(spec), "a.hair");
    EXPECT_THAT(hair.first_points, ::testing::ElementsAre(0u, 2u, 4u));
    EXPECT_THAT(hair.thickness, ::testing::ElementsAre(0.1f, 0.2f, 0.4f, 0.5f));
    EXPECT_EQ(hair.points[2], glm::vec3(1, 0, 1));
    EXPECT_EQ(hair.colors[3], glm::vec3(0.25f, 0.5f, 0.75f));
    spec.strands = 5;
    spec.segments = {0, 0, 0, 0, 0};
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("no strand has two points"));
}

TEST(HairFileTest, WrongCountsAreRefused) {
    HairSpec spec;
    spec.segments = {1, 3};
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("add up to 6 points, the header says 5"));
    spec = {};
    spec.flags = 30;
    spec.default_segments = 3;
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("2 strands of 3 segments have 8 points, not 5"));
    Bytes bytes = bytes_of({});
    bytes.push_back(0);
    EXPECT_THAT(refusal(bytes), HasSubstr("the file has 293 bytes"));
    spec = {};
    spec.flags = kAll - 2;
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("no points"));
    spec.flags = 32 + 2;
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("flags 0x22"));
    bytes = bytes_of({});
    bytes[0] = 'h';
    EXPECT_THAT(refusal(bytes), HasSubstr("does not begin with HAIR"));
}

TEST(HairFileTest, ValuesThatMeanNothingAreRefusedWithTheirPlace) {
    const float infinity = std::numeric_limits<float>::infinity();
    HairSpec spec;
    spec.points[4] = std::nanf("");
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("byte 148: coordinate nan"));
    spec = {};
    spec.points[0] = -infinity;
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("byte 132: coordinate -inf"));
    spec = {};
    spec.thickness[1] = -0.1f;
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("byte 196: thickness -0.1"));
    spec = {};
    spec.transparency[0] = 1.5f;
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("byte 212: transparency 1.5"));
    spec = {};
    spec.colors[14] = infinity;
    EXPECT_THAT(refusal(bytes_of(spec)), HasSubstr("byte 288: colour inf"));
}

TEST(HairFileTest, EveryTruncationIsRefused) {
    const Bytes whole = bytes_of(cylinder(200));
    ASSERT_EQ(parse_hair(whole, "a.hair").strands(), 200u);
    std::set<std::size_t> lengths = {0, 3, 4, 127, 128, whole.size() - 1};
    for (std::size_t percent = 1; percent < 100; ++percent) lengths.insert(whole.size() * percent / 100);
    for (std::size_t length : lengths) {
        const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
        EXPECT_NE(refusal(cut), "") << length;
    }
}

// A flipped bit of the header either contradicts the rest, or is one of the defaults or the info that this
// file does not depend on; nothing else may be read, and no size of the header's may be trusted.
TEST(HairFileTest, AFlippedHeaderBitIsAnErrorOrChangesNothing) {
    const Bytes whole = bytes_of(cylinder(200));
    const HairFile good = parse_hair(whole, "a.hair");
    for (std::size_t bit = 0; bit < 8 * 128; ++bit) {
        Bytes bytes = whole;
        bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
        if (bit < 8 * 16) {
            EXPECT_NE(refusal(bytes), "") << bit;
            continue;
        }
        const HairFile hair = parse_hair(bytes, "a.hair");
        EXPECT_EQ(hair.points, good.points) << bit;
        EXPECT_EQ(hair.first_points, good.first_points);
        EXPECT_EQ(hair.thickness, good.thickness);
        EXPECT_EQ(hair.transparency, good.transparency);
        EXPECT_EQ(hair.colors, good.colors);
    }
}

TEST(HairFileTest, HugeCountsInASmallFileAreRefusedBeforeAnythingIsAllocated) {
    Bytes bytes = bytes_of({});
    std::memset(bytes.data() + 4, 0xFF, 8);
    EXPECT_THAT(refusal(bytes), HasSubstr("4294967295 strands with 4294967295 points"));
}

TEST(HairFileTest, AMissingFileIsNamed) {
    try {
        load_hair("/nowhere/none.hair");
        FAIL() << "accepted";
    } catch (const UserError& error) {
        EXPECT_EQ(error.where(), "/nowhere/none.hair");
    }
}

}  // namespace
}  // namespace ropsim
