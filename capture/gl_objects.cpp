// Owners of OpenGL objects.
#include "capture/gl_objects.h"

#include "base/error.h"
#include "capture/shader_sources.h"

#include <vector>

#include <glm/gtc/type_ptr.hpp>

namespace ropsim {
namespace {

GLuint compile(GLenum stage, const std::string& label, const std::string& source) {
    const GLuint shader = glCreateShader(stage);
    const char* text = source.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint ok = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok != GL_TRUE) {
        std::vector<char> log(4096, '\0');
        glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size() - 1), nullptr, log.data());
        CHECK(ok == GL_TRUE, "shader of {}: {}", label, log.data());
    }
    return shader;
}

// The vertex shader with a main that moves what the scene's own main placed.
std::string shifted(std::string_view vertex) {
    return "#define main scene_main\n" + std::string(vertex) + "\n#undef main\n" +
           std::string(shader_source("vertex_shift"));
}

}  // namespace

GlProgram::GlProgram(const std::string& label, std::string_view vertex, std::string_view shading,
                     std::string_view fragment_main, std::string_view directives)
    : id_(glCreateProgram()) {
    const std::string version = "#version 450 core\n";
    const GLuint stages[2] = {
        compile(GL_VERTEX_SHADER, label, version + shifted(vertex)),
        compile(GL_FRAGMENT_SHADER, label,
                version + std::string(directives) + std::string(shader_source("surface")) +
                    std::string(shading) + "\n" + std::string(fragment_main))};
    for (GLuint stage : stages) glAttachShader(id_, stage);
    glLinkProgram(id_);
    for (GLuint stage : stages) glDeleteShader(stage);
    GLint ok = GL_FALSE;
    glGetProgramiv(id_, GL_LINK_STATUS, &ok);
    if (ok != GL_TRUE) {
        std::vector<char> log(4096, '\0');
        glGetProgramInfoLog(id_, static_cast<GLsizei>(log.size() - 1), nullptr, log.data());
        CHECK(ok == GL_TRUE, "shaders of {}: {}", label, log.data());
    }
}

void GlProgram::set(const char* name, const glm::mat4& value) const {
    glProgramUniformMatrix4fv(id_, glGetUniformLocation(id_, name), 1, GL_FALSE, glm::value_ptr(value));
}

void GlProgram::set(const char* name, const glm::vec4& value) const {
    set(name, &value, 1);
}

void GlProgram::set(const char* name, const glm::vec4* values, int count) const {
    glProgramUniform4fv(id_, glGetUniformLocation(id_, name), count, glm::value_ptr(*values));
}

void GlProgram::set(const char* name, std::uint32_t value) const {
    glProgramUniform1ui(id_, glGetUniformLocation(id_, name), value);
}

GlBuffer::GlBuffer(std::size_t bytes, const void* data) : bytes_(bytes) {
    glCreateBuffers(1, &id_);
    glNamedBufferStorage(id_, static_cast<GLsizeiptr>(bytes), data, GL_DYNAMIC_STORAGE_BIT);
    check_gl("allocating a buffer");
}

GlTarget::GlTarget(int width, int height, GLenum color_format, bool depth) : width_(width), height_(height) {
    glCreateFramebuffers(1, &framebuffer_);
    if (color_format == GL_NONE) {
        glNamedFramebufferParameteri(framebuffer_, GL_FRAMEBUFFER_DEFAULT_WIDTH, width);
        glNamedFramebufferParameteri(framebuffer_, GL_FRAMEBUFFER_DEFAULT_HEIGHT, height);
    } else {
        glCreateTextures(GL_TEXTURE_2D, 1, &color_);
        glTextureStorage2D(color_, 1, color_format, width, height);
        glNamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, color_, 0);
    }
    if (depth) {
        glCreateTextures(GL_TEXTURE_2D, 1, &depth_);
        glTextureStorage2D(depth_, 1, GL_DEPTH_COMPONENT32F, width, height);
        glNamedFramebufferTexture(framebuffer_, GL_DEPTH_ATTACHMENT, depth_, 0);
    }
    check_gl("allocating the image to draw into");
    const GLenum status = glCheckNamedFramebufferStatus(framebuffer_, GL_FRAMEBUFFER);
    if (status != GL_FRAMEBUFFER_COMPLETE) {
        throw UserError("--size",
                        fmt::format("the OpenGL driver cannot draw into {}x{} pixels; use a smaller size",
                                    width, height));
    }
}

GlTarget::~GlTarget() {
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteTextures(1, &color_);
    glDeleteTextures(1, &depth_);
}

void GlTarget::bind() const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glViewport(0, 0, width_, height_);
}

void check_gl(const char* where) {
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) return;
    if (error == GL_OUT_OF_MEMORY) {
        throw UserError("OpenGL",
                        fmt::format("out of memory {}; capture fewer fragments or a smaller size", where));
    }
    CHECK(error == GL_NO_ERROR, "{}: OpenGL error 0x{:04x}", where, error);
}

}  // namespace ropsim
