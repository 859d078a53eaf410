// The fragments that the software path draws: a scene's own geometry, or a trace's fragments as points.
#pragma once

#include "capture/gl_objects.h"
#include "capture/scene.h"
#include "traces/trace.h"

#include <cstdint>
#include <memory>
#include <string>

namespace ropsim {

// A program over all fragments, in arrival order; depth test, blending, targets and scissor are the caller's.
class ArrivalPass {
 public:
    virtual ~ArrivalPass() = default;
    // Uniforms of the pass's own text; those that the compiler removed are ignored.
    virtual void set(const char* name, std::uint32_t value) = 0;
    virtual void set(const char* name, const glm::vec4& value) = 0;
    virtual void set(const char* name, const glm::mat4& value) = 0;
    virtual void draw() = 0;
};

// GLSL of a pass: `text` has a main() that may call arrival() (shaders/software_path/arrival.glsl).
struct ArrivalText {
    std::string text;
    std::string directives;        // #extension lines
    bool reads_materials = false;  // else fragments have the least alpha that means the same
};

class Arrivals {
 public:
    virtual ~Arrivals() = default;
    // Of the frame: size, spatial samples, background, camera, draws, opaque layer.
    const TraceHeader& header() const { return *header_; }
    int width() const { return header_->width; }
    int height() const { return header_->height; }
    int samples() const { return header_->samples; }
    // What a user may call it: "geometry" or "fragments".
    virtual const char* kind() const = 0;
    // Throws UserError where the driver has no memory for it.
    virtual std::unique_ptr<ArrivalPass> pass(const ArrivalText& text) = 0;
    // What arrival.glsl declares besides arrival(), for passes over the screen too.
    void set_shared(const GlProgram& program) const;
    void bind_shared() const;

 protected:
    explicit Arrivals(const TraceHeader& header);
    Arrivals(const Arrivals&) = delete;
    Arrivals& operator=(const Arrivals&) = delete;
    // `text` behind what all passes share; `arrival`: the file that defines arrival().
    std::string whole(const ArrivalText& text, const char* arrival) const;

 private:
    struct TextureOwner {
        GLuint id = 0;
        TextureOwner() { glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id); }
        ~TextureOwner() { glDeleteTextures(1, &id); }
        TextureOwner(const TextureOwner&) = delete;
        TextureOwner& operator=(const TextureOwner&) = delete;
    };
    const TraceHeader* header_;
    GlBuffer draw_facts_;
    TextureOwner depth_;
    TextureOwner color_;
};

// All need a current GlContext for as long as they live. `header` must outlive them; one spatial sample
// (CHECK): with more, a trace's fragments are shaded where no rasteriser shades them.
std::unique_ptr<Arrivals> geometry_arrivals(const Scene& scene, const TraceHeader& header);
// The trace is read again for every pass.
std::unique_ptr<Arrivals> replayed_arrivals(TraceReader& trace);

}  // namespace ropsim
