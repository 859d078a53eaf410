// Uploads a scene's draw and issues ranges of it.
#include "capture/gpu_draw.h"

#include "base/error.h"
#include "capture/shader_sources.h"

namespace ropsim {

GpuDraw::GpuDraw(const SceneDraw& draw, const Camera& camera, std::string_view fragment_main)
    : program_(draw.state.name, draw.vertex, draw.shading, shader_source(fragment_main)),
      primitives_(draw.primitives),
      instances_(draw.instances),
      cull_back_faces_(draw.state.cull_back_faces) {
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
    if (draw.texture.width > 0) {
        glCreateTextures(GL_TEXTURE_2D, 1, &texture_);
        glTextureStorage2D(texture_, 1, GL_R32F, draw.texture.width, draw.texture.height);
        glTextureSubImage2D(texture_, 0, 0, 0, draw.texture.width, draw.texture.height, GL_RED, GL_FLOAT,
                            draw.texture.values.data());
        glTextureParameteri(texture_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTextureParameteri(texture_, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    }
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
    glDeleteTextures(1, &texture_);
    glDeleteVertexArrays(1, &vertex_array_);
}

void GpuDraw::submit(const DrawRange& range) const {
    program_.use();
    program_.set("u_first_instance", range.first_instance);
    program_.set("u_first_primitive", range.first_primitive);
    program_.set("u_primitives", primitives_);
    for (const auto& [binding, buffer] : buffers_) {
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.id());
    }
    glBindTextureUnit(0, texture_);
    glBindVertexArray(vertex_array_);
    if (cull_back_faces_) {
        glEnable(GL_CULL_FACE);
    } else {
        glDisable(GL_CULL_FACE);
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
