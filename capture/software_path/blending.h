// Targets that fragments are blended into: by the driver's fixed function or, where its rounding is not that
// of the stored format, in the shader.
#pragma once

#include "capture/software_path/arrivals.h"
#include "capture/software_path/render_targets.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

enum class BlendFunction : std::uint8_t {
    kAdd,       // source + target
    kOver,      // source + (1 - source alpha) target
    kMultiply,  // (1 - source) target, channel by channel
};

struct BlendedTarget {
    TargetSpec spec;
    BlendFunction rgb = BlendFunction::kAdd;
    BlendFunction alpha = BlendFunction::kAdd;  // of the fourth channel
    glm::vec4 clear{0.0f};
};

enum class Blending : std::uint8_t {
    kAutomatic,  // fixed function where it is exact to the format's rounding, else in the shader if it can
    kFixedFunction,  // as the driver rounds
    kShader,         // GL_EXT_shader_framebuffer_fetch
    kShaderCut,      // likewise, halves cut off instead of rounded: what a driver is thought to do
};

// What the driver does with values that its targets cannot hold, found by drawing.
struct DriverBlending {
    std::string version;          // GL_VERSION
    bool rounds_float16 = false;  // to nearest
    bool exact_unorm8 = false;    // the source of a blend is not rounded before it
    bool exact_snorm8 = false;
    bool framebuffer_fetch = false;
    std::string summary() const;
};
// Needs a current GlContext.
DriverBlending probe_blending();

// A pass that blends: the technique's GLSL defines `bool sources(Arrival a, out vec4 source[TARGETS])`, false
// for a fragment that is not to be seen.
class BlendPass {
 public:
    // Throws UserError where `blending` is not to be had from the driver.
    BlendPass(Arrivals& arrivals, const std::string& technique_text, bool reads_materials,
              std::vector<BlendedTarget> targets, Blending blending);
    ArrivalPass& pass() { return *pass_; }
    bool in_shader() const { return in_shader_; }
    // Into bound targets, which must be those of `targets`; leaves blending off.
    void draw();

 private:
    std::vector<BlendedTarget> targets_;
    bool in_shader_ = false;
    std::unique_ptr<ArrivalPass> pass_;
};

std::vector<TargetSpec> specs_of(const std::vector<BlendedTarget>& targets);

}  // namespace ropsim
