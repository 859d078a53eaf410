// Parts of the software path against what is known without OpenGL: formats, lists in arrival order,
// fingerprints.
#include "base/error.h"
#include "capture/shader_sources.h"
#include "capture/software_path/fragment_lists.h"
#include "capture/software_path/fragment_prints.h"
#include "capture/software_path/software_technique.h"
#include "tests/capture/test_scene.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"
#include "traces/half_float.h"

#include <bit>
#include <cmath>
#include <set>

namespace ropsim {
namespace {

class SoftwarePath : public testing::OpenGlTest {};

// Values where rounding is hard: ties, neighbours of ties, subnormals, the largest.
std::vector<float> hard_values() {
    std::vector<float> values = {0.0f, 1.0f,   65504.0f, 65519.0f,       65520.0f,
                                 1e6f, 1e-30f, 0x1p-25f, 0x1.000002p-25f};
    for (std::uint32_t half = 1; half < 0x7BFF; half += 37) {
        const float low = float_from_half(static_cast<std::uint16_t>(half));
        const float high = float_from_half(static_cast<std::uint16_t>(half + 1));
        const float middle = 0.5f * (low + high);
        values.insert(values.end(),
                      {low, middle, std::nextafter(middle, 0.0f), std::nextafter(middle, 1e9f)});
    }
    const std::size_t count = values.size();
    for (std::size_t i = 0; i < count; ++i) values.push_back(-values[i]);
    return values;
}

// What a GLSL function of stored_formats.glsl makes of the values.
std::vector<float> kept(const char* function, const std::vector<float>& values) {
    constexpr int kWidth = 64;
    const int height = static_cast<int>((values.size() + kWidth - 1) / kWidth);
    const GlBuffer buffer(values.size() * sizeof(float), values.data());
    const ScreenPass pass("formats",
                          std::string(shader_source("stored_formats")) +
                              "layout(std430, binding = 0) readonly buffer Values { float values[]; };\n"
                              "layout(location = 0) out vec4 o_kept;\n"
                              "void main() { uint at = uint(gl_FragCoord.y) * 64u + uint(gl_FragCoord.x);\n"
                              "  o_kept = vec4(" +
                              function + "(at < uint(values.length()) ? values[at] : 0.0)); }\n");
    const RenderTargets target({kWidth, height}, {{StoredAs::kFloat32, 1}});
    target.bind();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer.id());
    pass.draw();
    const std::vector<float> rgba = target.read(0);
    std::vector<float> result(values.size());
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = rgba[4 * i];
    return result;
}

TEST_F(SoftwarePath, ShadersRoundHalvesToNearestEven) {
    const GlContext context;
    const std::vector<float> values = hard_values();
    const std::vector<float> rounded = kept("kept_float16", values);
    const std::vector<float> cut = kept("cut_float16", values);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const float value = values[i];
        // The trace's own conversion stops at the largest half, where a target becomes infinite.
        const float expected = std::abs(value) >= 65520.0f ? std::copysign(INFINITY, value)
                                                           : float_from_half(half_from_float(value));
        EXPECT_EQ(rounded[i], expected) << value;
        EXPECT_LE(std::abs(cut[i]), std::abs(value)) << value;
        if (std::abs(value) >= 65504.0f) continue;
        EXPECT_LT(std::abs(value - cut[i]), std::max(std::abs(value) * 0x1p-10f, 0x1p-24f)) << value;
    }
}

TEST_F(SoftwarePath, ShadersRoundFixedPoint) {
    const GlContext context;
    const std::vector<float> values = {-1.0f,        0.0f,         0.4f / 255, 0.6f / 255, 128.4f / 255,
                                       128.6f / 255, 254.6f / 255, 1.0f,       7.0f};
    const std::vector<float> unorm = kept("kept_unorm8", values);
    const std::vector<float> expected = {0, 0, 0, 1, 128, 129, 255, 255, 255};
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(unorm[i], expected[i] / 255.0f) << values[i];
    const std::vector<float> signs = {-2.0f, -1.0f, -63.6f / 127, -0.4f / 127, 0.0f, 0.6f / 127, 1.0f};
    const std::vector<float> snorm = kept("kept_snorm8", signs);
    const std::vector<float> codes = {-127, -127, -64, 0, 0, 1, 127};
    for (std::size_t i = 0; i < signs.size(); ++i) EXPECT_EQ(snorm[i], codes[i] / 127.0f) << signs[i];
}

class ReplayedTrace : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        std::string why;
        if (!testing::opengl_available(why)) GTEST_SKIP() << "no OpenGL: " << why;
        options_.count = 3000;
        options_.width = 20;
        options_.height = 12;
        options_.draws = 2;
        options_.opaque = true;
        options_.materials = true;
        header_ = random_header(options_);
        chunk_ = random_chunk(options_);
        TraceWriter writer(path("trace"), header_);
        writer.append(chunk_);
        writer.finish();
    }
    RandomFragments options_;
    TraceHeader header_;
    FragmentChunk chunk_;
};

// Bands of few nodes, so that there are several; every pixel's list is the trace's, in its order.
TEST_F(ReplayedTrace, ListsHoldVisibleFragmentsInArrivalOrder) {
    const GlContext context;
    TraceReader trace(path("trace"));
    const auto arrivals = replayed_arrivals(trace);
    GpuFragmentLists lists(*arrivals, 700);
    int bands = 0;
    lists.for_bands([&] { ++bands; });
    EXPECT_GT(bands, 2);
    std::size_t seen = 0;
    for (int y = 0; y < header_.height; ++y)
        for (int x = 0; x < header_.width; ++x) {
            std::uint32_t before = 0;
            for (const ListedFragment& listed : lists.at(x, y)) {
                const Fragment& f = chunk_.fragments.at(listed.order);
                EXPECT_TRUE(f.x == x && f.y == y);
                EXPECT_TRUE(seen == 0 || listed.order >= before);
                EXPECT_EQ(listed.z, f.z);
                EXPECT_EQ(listed.primitive, f.primitive);
                const std::size_t pixel = static_cast<std::size_t>(y * header_.width + x);
                const bool tested = header_.draws[f.draw].depth_test;
                EXPECT_TRUE(!tested || f.z < header_.opaque->depth[pixel]);
                before = listed.order;
                ++seen;
            }
        }
    std::size_t visible = 0;
    for (const Fragment& f : chunk_.fragments)
        visible += !header_.draws[f.draw].depth_test ||
                   f.z < header_.opaque->depth[static_cast<std::size_t>(f.y * header_.width + f.x)];
    EXPECT_EQ(seen, visible);
    EXPECT_LT(visible, chunk_.fragments.size());
}

TEST_F(ReplayedTrace, ARowThatDoesNotFitIsRefused) {
    const GlContext context;
    TraceReader trace(path("trace"));
    const auto arrivals = replayed_arrivals(trace);
    GpuFragmentLists lists(*arrivals, 20);
    EXPECT_THROW(lists.for_bands([] {}), UserError);
}

TEST_F(ReplayedTrace, FingerprintsAreEqualUnlessABitDiffers) {
    const GlContext context;
    TraceReader trace(path("trace"));
    const auto arrivals = replayed_arrivals(trace);
    EXPECT_EQ(drawn_fragment_prints(*arrivals), traced_fragment_prints(trace));
    const auto visible = [&](const Fragment& f) {
        return !header_.draws[f.draw].depth_test ||
               f.z < header_.opaque->depth[static_cast<std::size_t>(f.y * header_.width + f.x)];
    };
    const auto changed = std::find_if(chunk_.fragments.begin(), chunk_.fragments.end(), visible);
    ASSERT_NE(changed, chunk_.fragments.end());
    changed->g = std::nextafter(changed->g, 2.0f);
    TraceWriter writer(path("other"), header_);
    writer.append(chunk_);
    writer.finish();
    TraceReader other(path("other"));
    const auto prints = drawn_fragment_prints(*arrivals);
    const auto others = traced_fragment_prints(other);
    for (std::size_t i = 0; i < prints.size(); ++i)
        EXPECT_EQ(prints[i] != others[i],
                  i == static_cast<std::size_t>(changed->y * header_.width + changed->x));
}

TEST(SoftwareTechniques, NamesAreUnique) {
    std::set<std::string_view> names;
    for (const SoftwareTechniqueInfo& info : software_techniques())
        EXPECT_TRUE(names.insert(info.name).second);
    EXPECT_GE(names.size(), 4u);
}

}  // namespace
}  // namespace ropsim
