// Owners of OpenGL objects; a context must be current whenever one is made, used or destroyed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <epoxy/gl.h>
#include <glm/glm.hpp>

namespace ropsim {

// A linked program. A shader that does not compile is our own mistake: CHECK with the driver's log.
class GlProgram {
 public:
    // GLSL texts without #version; the fragment stage is `directives` (#extension lines), `shading` and
    // `fragment_main`, in this order. `label` is for the log.
    GlProgram(const std::string& label, std::string_view vertex, std::string_view shading,
              std::string_view fragment_main, std::string_view directives = {});
    ~GlProgram() { glDeleteProgram(id_); }
    GlProgram(const GlProgram&) = delete;
    GlProgram& operator=(const GlProgram&) = delete;

    void use() const { glUseProgram(id_); }
    // Uniforms that the compiler removed are ignored.
    void set(const char* name, const glm::mat4& value) const;
    void set(const char* name, const glm::vec4& value) const;
    void set(const char* name, const glm::vec4* values, int count) const;
    void set(const char* name, std::uint32_t value) const;

 private:
    GLuint id_ = 0;
};

class GlBuffer {
 public:
    // `data` may be null (undefined contents). Throws UserError when the driver has no memory for it.
    GlBuffer(std::size_t bytes, const void* data);
    ~GlBuffer() { glDeleteBuffers(1, &id_); }
    GlBuffer(GlBuffer&& other) noexcept : id_(other.id_), bytes_(other.bytes_) { other.id_ = 0; }
    GlBuffer(const GlBuffer&) = delete;
    GlBuffer& operator=(const GlBuffer&) = delete;

    GLuint id() const { return id_; }
    std::size_t bytes() const { return bytes_; }

 private:
    GLuint id_ = 0;
    std::size_t bytes_ = 0;
};

// What is drawn into: width x height pixels with one float colour attachment and, optionally, float depth; or
// nothing at all (GL_NONE), where only the shader's own writes count.
class GlTarget {
 public:
    GlTarget(int width, int height, GLenum color_format, bool depth);
    ~GlTarget();
    GlTarget(const GlTarget&) = delete;
    GlTarget& operator=(const GlTarget&) = delete;
    void bind() const;  // with the viewport over all of it, origin top left

 private:
    int width_;
    int height_;
    GLuint framebuffer_ = 0;
    GLuint color_ = 0;
    GLuint depth_ = 0;
};

// Throws UserError with the driver's error, if any (out of memory above all); `where` is what was being done.
void check_gl(const char* where);

}  // namespace ropsim
