// The software path's own logarithm, exponential, sine and cosine against the C library in double precision.
#include "capture/gl_context.h"
#include "capture/shader_sources.h"
#include "capture/software_path/render_targets.h"
#include "tests/capture/test_scene.h"

#include <cmath>
#include <functional>

namespace ropsim {
namespace {

class SoftwareFunctions : public testing::OpenGlTest {};

// expression over `x` in GLSL, for each value.
std::vector<float> evaluated(const std::string& expression, const std::vector<float>& values) {
    const int width = static_cast<int>(values.size());
    const GlBuffer buffer(values.size() * sizeof(float), values.data());
    const ScreenPass pass("functions",
                          "layout(std430, binding = 0) readonly buffer Values { float values[]; };\n" +
                              std::string(shader_source("functions")) +
                              "layout(location = 0) out vec4 o_value;\n"
                              "void main() { float x = values[uint(gl_FragCoord.x)];\n"
                              "  o_value = vec4(" +
                              expression + "); }\n");
    const RenderTargets target({width, 1}, {{StoredAs::kFloat32, 1}});
    target.bind();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer.id());
    pass.draw();
    const std::vector<float> rgba = target.read(0);
    std::vector<float> result(values.size());
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = rgba[4 * i];
    return result;
}

// Rounded once, from double precision, all but the last bit must agree, and nearly always that too.
void expect_same(const std::string& expression, const std::vector<float>& values,
                 const std::function<double(double)>& function) {
    const std::vector<float> result = evaluated(expression, values);
    int off = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto expected = static_cast<float>(function(static_cast<double>(values[i])));
        off += result[i] != expected;
        EXPECT_TRUE(result[i] >= std::nextafter(expected, -INFINITY) &&
                    result[i] <= std::nextafter(expected, INFINITY))
            << expression << " of " << values[i] << ": " << result[i] << ", not " << expected;
    }
    EXPECT_LE(off, 1) << expression;
}

TEST_F(SoftwareFunctions, AreRoundedFromDoublePrecision) {
    const GlContext context;
    std::vector<float> positive;
    std::vector<float> negative;
    std::vector<float> turns;
    for (int i = 0; i < 4000; ++i) {
        const auto part = static_cast<float>(i) / 4000;
        positive.push_back(1.0f - part);
        positive.push_back(std::exp2(100 * part - 50));
        negative.push_back(-80 * part * part);
        turns.push_back(4 * part);
    }
    expect_same("natural_log(x)", positive, [](double x) { return std::log(x); });
    expect_same("exponential(x)", negative, [](double x) { return std::exp(x); });
    // Next to a zero of the function the last bit is that of the angle.
    const auto turned = [](auto function) {
        return [=](double x) { return function(6.283185307179586 * (x - std::floor(x))); };
    };
    std::vector<float> away;
    for (const float x : turns)
        if (std::abs(std::sin(6.2831853 * static_cast<double>(4 * x))) > 1e-3) away.push_back(x);
    expect_same("sine_cosine(x).x", away, turned([](double a) { return std::sin(a); }));
    expect_same("sine_cosine(x).y", away, turned([](double a) { return std::cos(a); }));
}

TEST_F(SoftwareFunctions, EndWhereFloatsDo) {
    const GlContext context;
    EXPECT_EQ(evaluated("natural_log(x)", {0.0f, -1.0f}), (std::vector<float>{-INFINITY, -INFINITY}));
    EXPECT_EQ(evaluated("exponential(x)", {-1000.0f, 0.0f, 1000.0f}), (std::vector<float>{0, 1, INFINITY}));
}

}  // namespace
}  // namespace ropsim
