// Images that the software path draws into and reads again.
#pragma once

#include "capture/gl_objects.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// What a target keeps of a channel.
enum class StoredAs : std::uint8_t { kFloat32, kFloat16, kUnorm8, kSnorm8 };
// float32, float16, unorm8 or snorm8, and back. Throws UserError, naming `where`, for anything else.
StoredAs stored_as(const std::string& name, const std::string& where);
const char* stored_name(StoredAs stored);

struct TargetSpec {
    StoredAs stored = StoredAs::kFloat32;
    int channels = 4;  // 1, 2 or 4
};

// Colour attachments of one size with, optionally, a float32 depth buffer; layers and samples where given.
struct TargetShape {
    int width = 0;
    int height = 0;
    int layers = 1;   // each bound by itself
    int samples = 1;  // above 1: multisampled
    bool depth = false;
};

class RenderTargets {
 public:
    // Throws UserError where the driver cannot.
    RenderTargets(const TargetShape& shape, const std::vector<TargetSpec>& colors);
    ~RenderTargets();
    RenderTargets(const RenderTargets&) = delete;
    RenderTargets& operator=(const RenderTargets&) = delete;

    // With the viewport over all of it, origin top left.
    void bind(int layer = 0) const;
    // What bind() has bound.
    void clear_color(int target, const glm::vec4& value) const;
    void clear_depth(float value) const;
    // For a sampler (array of layers, multisampled or not).
    void bind_color_texture(int target, GLuint unit) const {
        glBindTextureUnit(unit, textures_[index(target)]);
    }
    void bind_depth_texture(GLuint unit) const { glBindTextureUnit(unit, depth_); }
    // Four floats a pixel of a target that is not multisampled, row by row from the top: fixed-point codes
    // over their largest, exactly.
    std::vector<float> read(int target, int layer = 0) const;

 private:
    static std::size_t index(int target) { return static_cast<std::size_t>(target); }

    TargetShape shape_;
    std::vector<TargetSpec> specs_;
    std::vector<GLuint> textures_;
    GLuint depth_ = 0;
    std::vector<GLuint> framebuffers_;  // by layer
};

// A pass over every pixel: `text` has the main() of its fragment shader.
class ScreenPass {
 public:
    ScreenPass(const std::string& label, const std::string& text, const std::string& directives = {});
    ~ScreenPass() { glDeleteVertexArrays(1, &vertex_array_); }
    ScreenPass(const ScreenPass&) = delete;
    ScreenPass& operator=(const ScreenPass&) = delete;
    const GlProgram& program() const { return program_; }
    void draw() const;

 private:
    GlProgram program_;
    GLuint vertex_array_ = 0;
};

}  // namespace ropsim
