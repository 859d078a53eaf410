// Uploads a scene's draw and issues ranges of it.
#include "capture/gpu_draw.h"

#include "base/error.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

using Bytes = std::vector<std::uint8_t>;

// The next smaller level; with four channels a texel's colour counts as much as it covers.
Bytes half_size(const Bytes& level, int width, int height, int channels) {
    const int half_width = std::max(width / 2, 1);
    const int half_height = std::max(height / 2, 1);
    const auto count = static_cast<std::size_t>(channels);
    Bytes half(static_cast<std::size_t>(half_width) * static_cast<std::size_t>(half_height) * count);
    for (int y = 0; y < half_height; ++y)
        for (int x = 0; x < half_width; ++x) {
            float sum[4] = {};
            float weight = 0;
            for (int i = 0; i < 4; ++i) {
                const int from_x = std::min(2 * x + i % 2, width - 1);
                const int from_y = std::min(2 * y + i / 2, height - 1);
                const std::uint8_t* texel = &level[static_cast<std::size_t>(from_y * width + from_x) * count];
                const float covers = channels == 4 ? static_cast<float>(texel[3]) + 1e-3f : 1.0f;
                weight += covers;
                for (int c = 0; c < channels; ++c)
                    sum[c] += static_cast<float>(texel[c]) * (c == 3 ? 1.0f : covers);
            }
            std::uint8_t* out = &half[static_cast<std::size_t>(y * half_width + x) * count];
            for (int c = 0; c < channels; ++c)
                out[c] = static_cast<std::uint8_t>(std::lround(sum[c] / (c == 3 ? 4.0f : weight)));
        }
    return half;
}

GLuint upload(const SceneTexture& texture) {
    const auto power_of_two = [](int side) { return side > 0 && (side & (side - 1)) == 0; };
    const std::size_t expected = static_cast<std::size_t>(texture.width) *
                                 static_cast<std::size_t>(texture.height) *
                                 static_cast<std::size_t>(texture.channels);
    CHECK(power_of_two(texture.width) && power_of_two(texture.height) && texture.values.size() == expected &&
              (texture.channels == 1 || texture.channels == 4),
          "{}x{} with {} channels, {} values", texture.width, texture.height, texture.channels,
          texture.values.size());
    Bytes level(expected);
    for (std::size_t i = 0; i < expected; ++i)
        level[i] = static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(texture.values[i], 0.0f, 1.0f)));
    int width = texture.width;
    int height = texture.height;
    const int levels = 1 + static_cast<int>(std::log2(std::max(width, height)));
    GLuint id = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &id);
    glTextureStorage2D(id, levels, texture.channels == 4 ? GL_RGBA8 : GL_R8, width, height);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (int i = 0; i < levels; ++i) {
        glTextureSubImage2D(id, i, 0, 0, width, height, texture.channels == 4 ? GL_RGBA : GL_RED,
                            GL_UNSIGNED_BYTE, level.data());
        if (i + 1 < levels) level = half_size(level, width, height, texture.channels);
        width = std::max(width / 2, 1);
        height = std::max(height / 2, 1);
    }
    const GLint wrap = texture.repeat ? GL_REPEAT : GL_CLAMP_TO_EDGE;
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_WRAP_S, wrap);
    glTextureParameteri(id, GL_TEXTURE_WRAP_T, wrap);
    return id;
}

}  // namespace

GpuDraw::GpuDraw(const SceneDraw& draw, const Camera& camera, std::string_view fragment_main,
                 std::string_view defines)
    : GpuDraw(draw, camera, {{}, std::string(defines) + std::string(shader_source(fragment_main))}) {}

GpuDraw::GpuDraw(const SceneDraw& draw, const Camera& camera, const FragmentText& fragment_stage)
    : program_(draw.state.name, draw.vertex, draw.shading, fragment_stage.text, fragment_stage.directives),
      primitives_(draw.primitives),
      instances_(draw.instances),
      cull_(draw.state.cull) {
    GLint limit = 0;
    glGetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    for (const SceneBuffer& buffer : draw.buffers) {
        const std::size_t bytes = buffer.values.size() * sizeof(float);
        if (bytes > static_cast<std::size_t>(limit)) {
            throw UserError("--fragments",
                            fmt::format("the scene's geometry ({} MiB) is beyond the OpenGL driver's "
                                        "limit of {} MiB a buffer; ask for fewer fragments",
                                        bytes >> 20, limit >> 20));
        }
        buffers_.emplace_back(buffer.binding, GlBuffer(bytes, buffer.values.data()));
    }
    if (!draw.indices.empty()) {
        CHECK(draw.indices.size() == std::size_t{3} * draw.primitives, "{} indices, {} triangles",
              draw.indices.size(), draw.primitives);
        indices_ =
            std::make_unique<GlBuffer>(draw.indices.size() * sizeof(std::uint32_t), draw.indices.data());
    }
    CHECK(draw.textures.size() <= kMaxSceneTextures, "{}", draw.textures.size());
    for (const SceneTexture& texture : draw.textures) textures_.push_back(upload(texture));
    glCreateVertexArrays(1, &vertex_array_);
    if (indices_) glVertexArrayElementBuffer(vertex_array_, indices_->id());
    program_.set("u_view", camera.view);
    program_.set("u_projection", camera.projection);
    CHECK(draw.parameters.size() <= kMaxSceneParameters, "{}", draw.parameters.size());
    if (!draw.parameters.empty()) {
        program_.set("u_parameters", draw.parameters.data(), static_cast<int>(draw.parameters.size()));
    }
    check_gl("uploading the scene");
}

GpuDraw::~GpuDraw() {
    glDeleteTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
    glDeleteVertexArrays(1, &vertex_array_);
}

void GpuDraw::set_sample_position(SamplePosition position, int width, int height) const {
    // Clip space reaches from -1 to 1, with y up.
    program_.set("u_shift", glm::vec4(-2 * position.x() / static_cast<float>(width),
                                      2 * position.y() / static_cast<float>(height), 0, 0));
}

void GpuDraw::submit(const DrawRange& range) const {
    program_.use();
    program_.set("u_first_instance", range.first_instance);
    program_.set("u_first_primitive", range.first_primitive);
    program_.set("u_primitives", primitives_);
    GLint viewport[4] = {};
    glGetIntegerv(GL_VIEWPORT, viewport);
    program_.set("u_viewport", glm::vec4(viewport[2], viewport[3], 0, 0));
    for (const auto& [binding, buffer] : buffers_) {
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.id());
    }
    for (std::size_t i = 0; i < textures_.size(); ++i)
        glBindTextureUnit(static_cast<GLuint>(i), textures_[i]);
    glBindVertexArray(vertex_array_);
    if (cull_ == CullMode::kNone) {
        glDisable(GL_CULL_FACE);
    } else {
        glEnable(GL_CULL_FACE);
        glCullFace(cull_ == CullMode::kBack ? GL_BACK : GL_FRONT);
    }
    const auto vertices = static_cast<GLsizei>(3 * range.primitives);
    const auto instances = static_cast<GLsizei>(range.instances);
    const std::size_t first = std::size_t{3} * range.first_primitive;
    if (indices_) {
        // OpenGL takes the offset into the index buffer as a pointer.
        glDrawElementsInstanced(GL_TRIANGLES, vertices, GL_UNSIGNED_INT,
                                // NOLINTNEXTLINE(performance-no-int-to-ptr)
                                reinterpret_cast<const void*>(first * sizeof(std::uint32_t)), instances);
    } else {
        glDrawArraysInstanced(GL_TRIANGLES, static_cast<GLint>(first), vertices, instances);
    }
}

}  // namespace ropsim
