// Captures of .hair files: the file's transparency, thickness, colours and orientation.
#include "base/error.h"
#include "capture/capture.h"
#include "tests/capture/hair_bytes.h"
#include "tests/capture/own_file.h"
#include "tests/capture/test_scene.h"
#include "traces/trace.h"

#include <fstream>
#include <set>

#include <gmock/gmock.h>

namespace ropsim {
namespace {

using testing::Bytes;
using testing::bytes_of;
using testing::cylinder;
using testing::HairSpec;
using ::testing::HasSubstr;

class HairFileSceneTest : public testing::OpenGlTest {
 protected:
    std::string path(const std::string& name) const { return test::own_file(name); }
    CaptureSummary capture(const HairSpec& spec, std::optional<std::uint64_t> fragments = {}) const {
        const Bytes bytes = bytes_of(spec);
        std::ofstream(path("x.hair"), std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        CaptureOptions options;
        options.scene_or_file = path("x.hair");
        options.size = {320, 180};
        options.fragments = fragments;
        return capture_scene(options, path("trace"));
    }
    std::vector<Fragment> all() const {
        TraceReader reader(path("trace"));
        std::vector<Fragment> fragments;
        std::vector<Fragment> chunk;
        while (reader.next(chunk)) fragments.insert(fragments.end(), chunk.begin(), chunk.end());
        return fragments;
    }
};

// Strands wider than a pixel keep the file's alpha and the ratio of its colours' channels.
TEST_F(HairFileSceneTest, FragmentsHaveTheFilesTransparencyAndPrimitives) {
    HairSpec spec = cylinder(300);
    const CaptureSummary summary = capture(spec);
    EXPECT_THAT(summary.description, HasSubstr("300 strands"));
    std::set<std::uint32_t> primitives;
    for (const Fragment& f : all()) {
        EXPECT_EQ(f.a, 0.5f);
        primitives.insert(primitive_number(f));
    }
    std::uint32_t triangles = 0;
    for (std::uint16_t segments : spec.segments) triangles += 2u * segments;
    EXPECT_LE(*primitives.rbegin(), triangles - 1);
    EXPECT_GE(primitives.size(), triangles * 9 / 10);
}

TEST_F(HairFileSceneTest, UpInTheFileIsUpInTheImage) {
    // A red strand above a blue one, each along x.
    HairSpec spec;
    spec.segments = {1, 1};
    spec.points = {-1, 0, 0.5f, 1, 0, 0.5f, -1, 0, -0.5f, 1, 0, -0.5f};
    spec.thickness = {0.1f, 0.1f, 0.1f, 0.1f};
    spec.transparency = {0.5f, 0.5f, 0.5f, 0.5f};
    spec.colors = {1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1};
    capture(spec);
    int red = 0;
    int blue = 0;
    for (const Fragment& f : all()) {
        (f.r > f.b ? red : blue) += 1;
        EXPECT_EQ(f.y<90, f.r> f.b);
    }
    EXPECT_GT(red, 100);
    EXPECT_GT(blue, 100);
}

// Half as thick as the thinnest ribbon: half as opaque. Twice the thickness above it: twice the fragments.
TEST_F(HairFileSceneTest, ThicknessIsWidthOrWhereTooThinOpacity) {
    const auto with = [&](float thickness) {
        HairSpec spec = cylinder(100);
        for (float& value : spec.thickness) value = thickness;
        capture(spec);
        return all();
    };
    const std::vector<Fragment> thin = with(0.001f);
    const std::vector<Fragment> thinner = with(0.0005f);
    ASSERT_EQ(thin.size(), thinner.size());
    EXPECT_NEAR(thin[0].a, 2 * thinner[0].a, 1e-6f);
    const auto wide = static_cast<double>(with(0.04f).size());
    EXPECT_NEAR(static_cast<double>(with(0.08f).size()) / wide, 2.0, 0.1);
}

TEST_F(HairFileSceneTest, FragmentsFollowTheRequest) {
    for (std::uint64_t wanted : {5000, 200000}) {
        const CaptureSummary summary = capture(cylinder(2000), wanted);
        EXPECT_NEAR(static_cast<double>(summary.fragments) / static_cast<double>(wanted), 1.0, 0.03);
    }
}

TEST_F(HairFileSceneTest, WhatCannotBeSeenIsRefused) {
    HairSpec spec = cylinder(10);
    for (float& value : spec.transparency) value = 1;
    EXPECT_THROW(capture(spec), UserError);
    spec = cylinder(10);
    for (float& value : spec.points) value = 3;
    EXPECT_THROW(capture(spec), UserError);
}

}  // namespace
}  // namespace ropsim
