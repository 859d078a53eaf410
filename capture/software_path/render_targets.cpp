#include "capture/software_path/render_targets.h"

#include "base/error.h"
#include "capture/shader_sources.h"

#include <array>
#include <cmath>

namespace ropsim {
namespace {

constexpr std::array<const char*, 4> kNames = {"float32", "float16", "unorm8", "snorm8"};

GLenum internal_format(const TargetSpec& spec) {
    static constexpr GLenum kFormats[4][3] = {{GL_R32F, GL_RG32F, GL_RGBA32F},
                                              {GL_R16F, GL_RG16F, GL_RGBA16F},
                                              {GL_R8, GL_RG8, GL_RGBA8},
                                              {GL_R8_SNORM, GL_RG8_SNORM, GL_RGBA8_SNORM}};
    CHECK(spec.channels == 1 || spec.channels == 2 || spec.channels == 4, "{} channels", spec.channels);
    const int column = spec.channels == 4 ? 2 : spec.channels - 1;
    return kFormats[static_cast<std::size_t>(spec.stored)][column];
}

GLuint texture_of(const TargetShape& shape, GLenum format) {
    GLuint id = 0;
    glCreateTextures(shape.samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE_ARRAY : GL_TEXTURE_2D_ARRAY, 1, &id);
    if (shape.samples > 1)
        glTextureStorage3DMultisample(id, shape.samples, format, shape.width, shape.height, shape.layers,
                                      GL_TRUE);
    else
        glTextureStorage3D(id, 1, format, shape.width, shape.height, shape.layers);
    return id;
}

}  // namespace

StoredAs stored_as(const std::string& name, const std::string& where) {
    for (std::size_t i = 0; i < kNames.size(); ++i)
        if (name == kNames[i]) return static_cast<StoredAs>(i);
    throw UserError(where, fmt::format("the software path stores no {}; use float32, float16, unorm8 or "
                                       "snorm8",
                                       name));
}

const char* stored_name(StoredAs stored) {
    return kNames[static_cast<std::size_t>(stored)];
}

RenderTargets::RenderTargets(const TargetShape& shape, const std::vector<TargetSpec>& colors)
    : shape_(shape), specs_(colors) {
    for (const TargetSpec& spec : specs_) textures_.push_back(texture_of(shape, internal_format(spec)));
    if (shape.depth) depth_ = texture_of(shape, GL_DEPTH_COMPONENT32F);
    check_gl("allocating images to draw into");
    framebuffers_.resize(static_cast<std::size_t>(shape.layers));
    glCreateFramebuffers(shape.layers, framebuffers_.data());
    for (std::size_t layer = 0; layer < framebuffers_.size(); ++layer) {
        const GLuint id = framebuffers_[layer];
        std::vector<GLenum> buffers;
        for (std::size_t i = 0; i < textures_.size(); ++i) {
            buffers.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i));
            glNamedFramebufferTextureLayer(id, buffers.back(), textures_[i], 0, static_cast<GLint>(layer));
        }
        if (shape.depth)
            glNamedFramebufferTextureLayer(id, GL_DEPTH_ATTACHMENT, depth_, 0, static_cast<GLint>(layer));
        glNamedFramebufferDrawBuffers(id, static_cast<GLsizei>(buffers.size()), buffers.data());
        if (glCheckNamedFramebufferStatus(id, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
            throw UserError("OpenGL",
                            fmt::format("the driver cannot draw into {}x{} pixels of these formats; "
                                        "use a smaller size or fewer samples",
                                        shape.width, shape.height));
    }
}

RenderTargets::~RenderTargets() {
    glDeleteFramebuffers(static_cast<GLsizei>(framebuffers_.size()), framebuffers_.data());
    glDeleteTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
    glDeleteTextures(1, &depth_);
}

void RenderTargets::bind(int layer) const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[index(layer)]);
    glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glViewport(0, 0, shape_.width, shape_.height);
}

void RenderTargets::clear_color(int target, const glm::vec4& value) const {
    glClearBufferfv(GL_COLOR, target, &value.x);
}

void RenderTargets::clear_depth(float value) const {
    glClearBufferfv(GL_DEPTH, 0, &value);
}

std::vector<float> RenderTargets::read(int target, int layer) const {
    CHECK(shape_.samples == 1, "{} samples", shape_.samples);
    bind(layer);
    glReadBuffer(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(target));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    std::vector<float> values(std::size_t{4} * index(shape_.width) * index(shape_.height));
    glReadPixels(0, 0, shape_.width, shape_.height, GL_RGBA, GL_FLOAT, values.data());
    check_gl("reading an image");
    const StoredAs stored = specs_[index(target)].stored;
    const float codes = stored == StoredAs::kUnorm8 ? 255.0f : stored == StoredAs::kSnorm8 ? 127.0f : 0.0f;
    if (codes != 0.0f)
        for (float& value : values) value = std::round(value * codes) / codes;
    return values;
}

ScreenPass::ScreenPass(const std::string& label, const std::string& text, const std::string& directives)
    : program_(label, shader_source("screen_vertex"), {}, text, directives) {
    glCreateVertexArrays(1, &vertex_array_);
}

void ScreenPass::draw() const {
    program_.use();
    glBindVertexArray(vertex_array_);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    check_gl("drawing over the screen");
}

}  // namespace ropsim
