// One draw of a scene, uploaded: its data, its programs, and any range of its triangles.
#pragma once

#include "capture/gl_objects.h"
#include "capture/scene.h"
#include "traces/sample_positions.h"

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

// Whole instances, or a range of the triangles of one instance.
struct DrawRange {
    std::uint32_t first_instance = 0;
    std::uint32_t instances = 1;
    std::uint32_t first_primitive = 0;  // within the instance
    std::uint32_t primitives = 0;
};

// What follows a draw's shading in its fragment shader, and the #extension lines that precede all of it.
struct FragmentText {
    std::string directives;
    std::string text;
};

class GpuDraw {
 public:
    // Uploads the data and links the program whose fragment shader is the draw's shading followed by the
    // text of capture/shaders/<fragment_main>.glsl, with `defines` before it. Throws UserError when it does
    // not fit.
    GpuDraw(const SceneDraw& draw, const Camera& camera, std::string_view fragment_main,
            std::string_view defines = {});
    GpuDraw(const SceneDraw& draw, const Camera& camera, const FragmentText& fragment_stage);
    ~GpuDraw();
    GpuDraw(const GpuDraw&) = delete;
    GpuDraw& operator=(const GpuDraw&) = delete;

    const GlProgram& program() const { return program_; }
    DrawRange everything() const { return {0, instances_, 0, primitives_}; }
    // Shifts the picture so that this position within every pixel comes to lie on the pixel's centre.
    void set_sample_position(SamplePosition position, int width, int height) const;
    void submit(const DrawRange& range) const;

 private:
    GlProgram program_;
    std::vector<std::pair<std::uint32_t, GlBuffer>> buffers_;
    std::unique_ptr<GlBuffer> indices_;
    std::vector<GLuint> textures_;
    GLuint vertex_array_ = 0;
    std::uint32_t primitives_;
    std::uint32_t instances_;
    CullMode cull_;
};

}  // namespace ropsim
