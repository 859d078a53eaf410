// The C interface for programs outside ropsim, and the example that uses it.
#include "capture/client/ropsim_trace_client.h"
#include "tests/capture/test_scene.h"
#include "traces/generators.h"
#include "traces/trace.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

struct FreeTrace {
    void operator()(RopsimTrace* trace) const { ropsim_trace_free(trace); }
};
using Trace = std::unique_ptr<RopsimTrace, FreeTrace>;

std::string scratch(const std::string& name) {
    std::string path = ::testing::TempDir() + "/trace_client_" + name + ".trace";
    std::filesystem::remove(path);
    return path;
}

RopsimTraceInfo info(int width = 32, int height = 16) {
    RopsimTraceInfo result = {};
    result.width = width;
    result.height = height;
    return result;
}

// A record buffer as the shader leaves it: `arrived` in the first word, room for what is given.
std::vector<std::uint32_t> record_buffer(const std::vector<Fragment>& fragments, std::uint32_t arrived) {
    std::vector<std::uint32_t> words(8 + 8 * fragments.size());
    words[0] = arrived;
    if (!fragments.empty()) std::memcpy(&words[8], fragments.data(), fragments.size() * sizeof(Fragment));
    return words;
}

int append(const Trace& trace, const std::vector<std::uint32_t>& words) {
    return ropsim_trace_append_records(trace.get(), words.data(), words.size() * sizeof(std::uint32_t));
}

TEST(TraceClientTest, RecordsComeOutInRasterOrderWhateverOrderTheyArrivedIn) {
    // Draw by draw, triangle by triangle, then by tile, quad and pixel, from the top.
    std::vector<Fragment> expected;
    const int pixels[][2] = {{0, 0}, {1, 0}, {0, 1},  {1, 1}, {2, 0},
                             {0, 2}, {8, 0}, {31, 7}, {0, 8}, {31, 15}};
    for (std::uint16_t draw = 0; draw < 2; ++draw)
        for (std::uint32_t primitive : {7u, 8u, 1000u})
            for (const auto& pixel : pixels)
                expected.push_back({0.5f, 0.25f, 0.125f, 0.0f, 0.5f, static_cast<std::uint16_t>(pixel[0]),
                                    static_cast<std::uint16_t>(pixel[1]), primitive, 1, draw});
    // Which way a triangle faces says nothing about its place.
    for (Fragment& fragment : expected)
        if (fragment.primitive == 8) fragment.primitive |= kBackFacing;
    std::vector<Fragment> arrived = expected;
    for (Fragment& fragment : arrived) fragment.y = static_cast<std::uint16_t>(15 - fragment.y);
    std::shuffle(arrived.begin(), arrived.end(), std::mt19937(1));
    const std::string path = scratch("order");
    RopsimTraceInfo bottom_up = info();
    bottom_up.bottom_up = 1;
    const Trace trace(ropsim_trace_create(path.c_str(), &bottom_up));
    const RopsimDraw draw = {};
    std::uint32_t number = 9;
    ASSERT_EQ(ropsim_trace_add_draw(trace.get(), &draw, nullptr), 0);
    ASSERT_EQ(ropsim_trace_add_draw(trace.get(), &draw, &number), 0);
    EXPECT_EQ(number, 1u);
    EXPECT_EQ(append(trace, record_buffer(arrived, 60)), 0) << ropsim_trace_error(trace.get());
    EXPECT_FALSE(std::filesystem::exists(path)) << "before it is finished";
    ASSERT_EQ(ropsim_trace_finish(trace.get()), 0) << ropsim_trace_error(trace.get());
    const std::vector<Fragment> read = read_fragments(path);
    ASSERT_EQ(read.size(), expected.size());
    for (std::size_t i = 0; i < read.size(); ++i)
        EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(&read[i], 1)),
                                       std::as_bytes(std::span(&expected[i], 1))))
            << i;
}

TEST(TraceClientTest, HeaderSaysWhatItWasTold) {
    const std::string path = scratch("header");
    RopsimTraceInfo told = info(3, 2);
    told.samples = 2;
    told.bottom_up = 1;
    told.half_colors = 1;
    told.background[2] = 0.25f;
    told.scene = "a test";
    const Trace trace(ropsim_trace_create(path.c_str(), &told));
    RopsimCamera camera = {};
    for (int i = 0; i < 16; ++i) {
        camera.view[i] = static_cast<float>(i);
        camera.projection[i] = static_cast<float>(-i);
    }
    camera.near_plane = 0.5f;
    camera.far_plane = 10;
    camera.fovy_degrees = 45;
    ASSERT_EQ(ropsim_trace_set_camera(trace.get(), &camera), 0);
    std::vector<float> rgb(std::size_t{3} * 2 * 2 * 3);
    std::vector<float> depth(std::size_t{3} * 2 * 2);
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<float>(i);
    for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = 0.05f * static_cast<float>(i);
    depth[3] = std::numeric_limits<float>::infinity();
    ASSERT_EQ(ropsim_trace_set_opaque(trace.get(), rgb.data(), depth.data()), 0);
    RopsimDraw draw = {};
    draw.name = "glass";
    draw.depth_test = 1;
    draw.blend = kRopsimAdditive;
    draw.cull = kRopsimCullFront;
    draw.full = {30, 2, 16};
    draw.alpha = {5, 1, 4};
    draw.cost_source = "counted";
    ASSERT_EQ(ropsim_trace_add_draw(trace.get(), &draw, nullptr), 0);
    const RopsimFragment fragment = {0.5f, 1, 0, 0, 1, 2, 0, 77, 3, 0};
    ASSERT_EQ(ropsim_trace_append_fragments(trace.get(), &fragment, 1), 0);
    ASSERT_EQ(ropsim_trace_finish(trace.get()), 0) << ropsim_trace_error(trace.get());

    const TraceReader reader(path);
    const TraceHeader& header = reader.header();
    EXPECT_EQ(header.width, 3);
    EXPECT_EQ(header.height, 2);
    EXPECT_EQ(header.samples, 2);
    EXPECT_EQ(header.background, glm::vec3(0, 0, 0.25f));
    EXPECT_EQ(header.scene, "a test");
    EXPECT_EQ(header.color_storage, ColorStorage::kFloat16);
    ASSERT_TRUE(header.camera);
    EXPECT_EQ(header.camera->view[1][2], 6.0f) << "column-major";
    EXPECT_EQ(header.camera->metres_per_unit, 1.0f);
    EXPECT_FALSE(header.light);
    ASSERT_EQ(header.draws.size(), 1u);
    EXPECT_EQ(header.draws[0].name, "glass");
    EXPECT_TRUE(header.draws[0].depth_test);
    EXPECT_FALSE(header.draws[0].depth_write);
    EXPECT_EQ(header.draws[0].blend, BlendMode::kAdditive);
    EXPECT_EQ(header.draws[0].cull, CullMode::kFront);
    EXPECT_EQ(header.draws[0].full.texture_bytes, 16u);
    EXPECT_EQ(header.draws[0].alpha.alu_instructions, 5u);
    EXPECT_EQ(header.draws[0].cost_source, "counted");
    ASSERT_TRUE(header.opaque);
    // Rows of three pixels with two samples, the lower one first as given.
    EXPECT_EQ(header.opaque->rgb[0], 18.0f);
    EXPECT_EQ(header.opaque->rgb[18], 0.0f);
    EXPECT_EQ(header.opaque->depth[0], depth[6]);
    EXPECT_EQ(header.opaque->depth[9], std::numeric_limits<float>::infinity());
    EXPECT_EQ(read_fragments(path).at(0).y, 1);
    EXPECT_EQ(read_fragments(path).at(0).coverage, 3);
}

TEST(TraceClientTest, LostRecordsAreCountedAndRefused) {
    const std::vector<Fragment> room(10, Fragment{0.5f, 0, 0, 0, 0.5f, 1, 1, 0, 1, 0});
    const std::vector<std::uint32_t> words = record_buffer(room, 13);
    EXPECT_EQ(ropsim_records_lost(words.data(), words.size() * 4), 3u);
    EXPECT_EQ(ropsim_records_lost(record_buffer(room, 10).data(), words.size() * 4), 0u);
    const std::string path = scratch("lost");
    const RopsimTraceInfo small = info();
    const Trace trace(ropsim_trace_create(path.c_str(), &small));
    const RopsimDraw draw = {};
    ASSERT_EQ(ropsim_trace_add_draw(trace.get(), &draw, nullptr), 0);
    EXPECT_EQ(append(trace, words), 1);
    EXPECT_THAT(ropsim_trace_error(trace.get()), HasSubstr("13 fragments arrived where 10 fit"));
    // Sticky, and nothing is left.
    EXPECT_EQ(append(trace, record_buffer(room, 10)), 1);
    EXPECT_EQ(ropsim_trace_finish(trace.get()), 1);
    EXPECT_FALSE(std::filesystem::exists(path));
}

// The error that appending `fragment` to a trace of one draw gives.
std::string fault(Fragment fragment, bool as_record) {
    const RopsimTraceInfo small = info();
    const Trace trace(ropsim_trace_create(scratch("fault").c_str(), &small));
    const RopsimDraw draw = {};
    ropsim_trace_add_draw(trace.get(), &draw, nullptr);
    if (as_record) {
        append(trace, record_buffer({fragment, Fragment{0.5f, 0, 0, 0, 0.5f, 1, 1, 0, 1, 0}}, 2));
    } else {
        RopsimFragment plain;
        std::memcpy(&plain, &fragment, sizeof plain);
        ropsim_trace_append_fragments(trace.get(), &plain, 1);
    }
    return ropsim_trace_error(trace.get());
}

TEST(TraceClientTest, WhatATraceCannotHoldIsAnErrorAndNoCrash) {
    const Fragment good{0.5f, 0, 0, 0, 0.5f, 1, 1, 0, 1, 0};
    for (bool as_record : {false, true}) {
        EXPECT_EQ(fault(good, as_record), "");
        Fragment bad = good;
        bad.x = 32;
        EXPECT_THAT(fault(bad, as_record), HasSubstr("pixel (32, 1) is outside the 32x16 image"));
        bad = good;
        bad.draw = 1;
        EXPECT_THAT(fault(bad, as_record), HasSubstr("draw 1"));
        bad = good;
        bad.coverage = 2;
        EXPECT_THAT(fault(bad, as_record), HasSubstr("samples 0x2"));
        bad = good;
        bad.a = std::numeric_limits<float>::quiet_NaN();
        EXPECT_THAT(fault(bad, as_record), HasSubstr("from 0 to 1"));
    }
    Fragment far = good;
    far.primitive = 0xFFFFFFFFu;
    EXPECT_THAT(fault(far, true), HasSubstr("number them consecutively"));
    EXPECT_EQ(fault(far, false), "");
}

TEST(TraceClientTest, WrongCallsAreErrors) {
    const RopsimTraceInfo small = info();
    const RopsimDraw draw = {};
    const RopsimCamera camera = {};
    const std::vector<std::uint32_t> empty = record_buffer({}, 0);
    const Trace no_draw(ropsim_trace_create(scratch("none").c_str(), &small));
    EXPECT_EQ(append(no_draw, empty), 1);
    EXPECT_THAT(ropsim_trace_error(no_draw.get()), HasSubstr("no draw was added"));
    const Trace late(ropsim_trace_create(scratch("late").c_str(), &small));
    EXPECT_EQ(ropsim_trace_add_draw(late.get(), &draw, nullptr), 0);
    EXPECT_EQ(append(late, empty), 0);
    EXPECT_EQ(ropsim_trace_set_camera(late.get(), &camera), 1);
    EXPECT_THAT(ropsim_trace_error(late.get()), HasSubstr("before the first append"));
    RopsimTraceInfo odd = info();
    odd.samples = 3;
    const Trace three(ropsim_trace_create(scratch("odd").c_str(), &odd));
    EXPECT_THAT(ropsim_trace_error(three.get()), HasSubstr("samples 1, 2, 4, 8 or 16"));
    EXPECT_EQ(ropsim_trace_set_opaque(three.get(), nullptr, nullptr), 1);
    odd.samples = 4;
    const Trace four(ropsim_trace_create(scratch("four").c_str(), &odd));
    EXPECT_EQ(ropsim_trace_add_draw(four.get(), &draw, nullptr), 0);
    EXPECT_EQ(append(four, empty), 1);
    EXPECT_THAT(ropsim_trace_error(four.get()), HasSubstr("one spatial sample"));
    const Trace nowhere(ropsim_trace_create("/nowhere/at/all.trace", &small));
    EXPECT_EQ(ropsim_trace_add_draw(nowhere.get(), &draw, nullptr), 0);
    EXPECT_EQ(ropsim_trace_finish(nowhere.get()), 1);
    EXPECT_THAT(ropsim_trace_error(nowhere.get()), HasSubstr("/nowhere/at/all.trace"));
    const Trace null(ropsim_trace_create(nullptr, nullptr));
    EXPECT_EQ(ropsim_trace_finish(null.get()), 1);
    EXPECT_EQ(ropsim_trace_finish(nullptr), 1);
    ropsim_trace_free(nullptr);
}

TEST(TraceClientTest, TheExampleLeavesTheFragmentsThatItsTrianglesCover) {
    std::string why;
    if (!testing::opengl_available(why)) GTEST_SKIP() << "no OpenGL: " << why;
    const std::string path = scratch("example");
    ASSERT_EQ(std::system((std::string(ROPSIM_TRACE_CLIENT_EXAMPLE) + " " + path).c_str()), 0);
    const TraceReader reader(path);
    EXPECT_EQ(reader.header().draws.at(0).cost_source, "counted by hand");
    EXPECT_EQ(reader.header().draws.at(1).name, "glass");
    const std::vector<Fragment> fragments = read_fragments(path);
    // Two layers over 64 x 48 pixels, then the centres with x + y < 32.5 from the corner: 1 + 2 + ... + 32.
    ASSERT_EQ(fragments.size(), 2u * 64 * 48 + 32 * 33 / 2);
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const Fragment& f = fragments[i];
        EXPECT_FALSE(faces_back(f)) << "its triangles run counterclockwise";
        if (i < std::size_t{2} * 64 * 48) {
            EXPECT_EQ(f.draw, 0);
            EXPECT_EQ(primitive_number(f), i / (std::size_t{64} * 48)) << "one instance after the other";
            EXPECT_NEAR(f.z, primitive_number(f) == 0 ? 0.75f : 0.25f, 1e-6f);
            EXPECT_EQ(f.a, 0.25f);
            EXPECT_EQ(f.r, 0.25f);
        } else {
            EXPECT_EQ(f.draw, 1);
            EXPECT_EQ(primitive_number(f), 0u);
            EXPECT_NEAR(f.z, 0.5f, 1e-6f);
            EXPECT_EQ(f.a, 0.5f);
            EXPECT_EQ(f.g, 0.5f);
            EXPECT_EQ(f.r, 0.0f);
            // The right angle is 8 pixels from the lower left.
            EXPECT_GE(f.x, 8);
            EXPECT_LE(f.y, 47 - 8);
            EXPECT_LE((f.x - 8) + (47 - 8 - f.y), 31);
        }
    }
}

}  // namespace
}  // namespace ropsim
