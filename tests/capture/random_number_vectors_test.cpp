// The software path's GLSL draws the numbers that docs/random-numbers.md specifies.
#include "capture/gl_context.h"
#include "capture/shader_sources.h"
#include "capture/software_path/render_targets.h"
#include "tests/base/test_vectors.h"

#include <map>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::TestVector;

// One vector a pixel: arguments come as pairs of words, the result goes out in 16-bit pieces, which floats
// hold.
constexpr const char* kMain = R"(
layout(std430, binding = 0) readonly buffer Vectors { uvec2 arguments[]; };
uniform uint u_width;
layout(location = 0) out vec4 o_result;

uvec2 word(uint value) { return uvec2(value, 0u); }
uvec2 result(uint at) {
    uint name = arguments[at].x;
    uvec2 a = arguments[at + 1u], b = arguments[at + 2u], c = arguments[at + 3u], d = arguments[at + 4u];
    uvec2 e = arguments[at + 5u], f = arguments[at + 6u], g = arguments[at + 7u];
    if (name == 0u) return mix64(a);
    if (name == 1u) return word(random_bits(a, b.x));
    if (name == 2u) return word(floatBitsToUint(random_unit(a, b.x)));
    if (name == 3u) return fragment_key(a, b, c.x, d.x);
    if (name == 4u) return coin_mask(a, b.x, uintBitsToFloat(c.x));
    if (name == 5u) return chosen_mask(a, b.x, c, uintBitsToFloat(d.x), uvec2(e.x, f.x), g.x != 0u);
    if (name == 6u) return run_mask(a, b.x, uintBitsToFloat(c.x), uvec2(d.x, e.x), f.x != 0u);
    if (name == 7u) return covering_mask(a.x, uintBitsToFloat(b.x));
    if (name == 8u) return word(floatBitsToUint(dither_threshold(uvec2(a.x, b.x))));
    if (name == 9u) return word(hilbert_index(a.x, uvec2(b.x, c.x)));
    if (name == 10u) return word(morton_index(uvec2(a.x, b.x)));
    if (name == 11u) return word(opacity_reference(a.x, b.x));
    return word(hash_words(uvec3(a.x, b.x, c.x), d.x));
}
void main() {
    uvec2 r = result(8u * (uint(gl_FragCoord.y) * u_width + uint(gl_FragCoord.x)));
    o_result = vec4(r.x & 0xFFFFu, r.x >> 16, r.y & 0xFFFFu, r.y >> 16);
}
)";
const std::map<std::string, std::uint64_t> recipe_numbers = {
    {"mix", 0},     {"bits", 1},       {"unit", 2},   {"key", 3},    {"coin", 4},
    {"choose", 5},  {"run", 6},        {"covers", 7}, {"dither", 8}, {"hilbert", 9},
    {"morton", 10}, {"reference", 11}, {"words", 12}};

TEST(RandomNumberVectors, ShadersDrawThem) {
    const auto vectors = test::read_test_vectors(ROPSIM_SOURCE_DIR "/docs/random-number-vectors.txt");
    ASSERT_GT(vectors.size(), 500u);
    constexpr int kWidth = 32;
    const int height = static_cast<int>((vectors.size() + kWidth - 1) / kWidth);
    std::vector<std::uint64_t> words(8 * static_cast<std::size_t>(kWidth * height), 0);
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        ASSERT_TRUE(recipe_numbers.contains(vectors[i].name)) << vectors[i].line;
        ASSERT_LE(vectors[i].arguments.size(), 7u);
        words[8 * i] = recipe_numbers.at(vectors[i].name);
        std::copy(vectors[i].arguments.begin(), vectors[i].arguments.end(),
                  words.begin() + static_cast<std::ptrdiff_t>(8 * i + 1));
    }
    const GlContext context;
    const ScreenPass pass("test vectors", std::string(shader_source("random")) + kMain);
    const GlBuffer buffer(words.size() * sizeof words[0], words.data());
    const RenderTargets target({kWidth, height}, {{StoredAs::kFloat32, 4}});
    target.bind();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer.id());
    pass.program().set("u_width", std::uint32_t{kWidth});
    pass.draw();
    const std::vector<float> pieces = target.read(0);
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        std::uint64_t result = 0;
        for (std::size_t c = 4; c-- > 0;)
            result = result << 16 | static_cast<std::uint64_t>(pieces[4 * i + c]);
        EXPECT_EQ(result, vectors[i].result) << vectors[i].line;
    }
}

}  // namespace
}  // namespace ropsim
