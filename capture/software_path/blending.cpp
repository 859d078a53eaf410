#include "capture/software_path/blending.h"

#include "base/error.h"
#include "capture/shader_sources.h"

#include <cmath>

#include <epoxy/gl.h>

namespace ropsim {
namespace {

void set_function(GLuint target, const BlendedTarget& t) {
    const auto factors = [](BlendFunction f) -> std::pair<GLenum, GLenum> {
        switch (f) {
            case BlendFunction::kOver:
                return {GL_ONE, GL_ONE_MINUS_SRC_ALPHA};
            case BlendFunction::kMultiply:
                return {GL_ZERO, GL_ONE_MINUS_SRC_COLOR};
            case BlendFunction::kAdd:
                break;
        }
        return {GL_ONE, GL_ONE};
    };
    const auto [rgb_source, rgb_target] = factors(t.rgb);
    const auto [alpha_source, alpha_target] = factors(t.alpha);
    glBlendFuncSeparatei(target, rgb_source, rgb_target, alpha_source, alpha_target);
}

// The blend of target i as GLSL, each operation rounded by itself.
std::string blend_text(std::size_t i, const BlendedTarget& t, bool cut) {
    const auto of = [&](BlendFunction f, const char* c) {
        switch (f) {
            case BlendFunction::kOver:
                return fmt::format("s[{0}].{1} + t * stored.{1}", i, c);
            case BlendFunction::kMultiply:
                return fmt::format("(1.0 - s[{0}].{1}) * stored.{1}", i, c);
            case BlendFunction::kAdd:
                break;
        }
        return fmt::format("stored.{1} + s[{0}].{1}", i, c);
    };
    const std::string kept = cut && t.spec.stored == StoredAs::kFloat16
                                 ? "cut_float16"
                                 : fmt::format("kept_{}", stored_name(t.spec.stored));
    // A fixed-point target is read as its driver converts codes; they are made exact here. A blend clamps its
    // sources to what such a target can hold.
    const std::string clamp =
        t.spec.stored == StoredAs::kUnorm8   ? fmt::format("        s[{0}] = clamp(s[{0}], 0.0, 1.0);\n", i)
        : t.spec.stored == StoredAs::kSnorm8 ? fmt::format("        s[{0}] = clamp(s[{0}], -1.0, 1.0);\n", i)
                                             : "";
    return fmt::format(
        "    {{\n{4}        vec4 stored = kept_{5}(o_target{0});\n        precise float t = 1.0 - s[{0}].a;\n"
        "        precise vec4 sum = vec4({1}, {2});\n        o_target{0} = {3}(sum);\n    }}\n",
        i, of(t.rgb, "rgb"), of(t.alpha, "a"), kept, clamp, stored_name(t.spec.stored));
}

std::string main_text(const std::vector<BlendedTarget>& targets, bool in_shader, bool cut) {
    std::string text;
    const char* qualifier = in_shader ? "inout" : "out";
    for (std::size_t i = 0; i < targets.size(); ++i)
        text += fmt::format("layout(location = {0}) {1} vec4 o_target{0};\n", i, qualifier);
    text += fmt::format("void main() {{\n    vec4 s[{}];\n    if (!sources(arrival(), s)) discard;\n",
                        targets.size());
    for (std::size_t i = 0; i < targets.size(); ++i)
        text += in_shader ? blend_text(i, targets[i], cut) : fmt::format("    o_target{0} = s[{0}];\n", i);
    return text + "}\n";
}

// Whether the driver's fixed function keeps what the format keeps.
bool exact(StoredAs stored, const DriverBlending& driver) {
    switch (stored) {
        case StoredAs::kFloat16:
            return driver.rounds_float16;
        case StoredAs::kUnorm8:
            return driver.exact_unorm8;
        case StoredAs::kSnorm8:
            return driver.exact_snorm8;
        case StoredAs::kFloat32:
            break;
    }
    return true;
}

bool blends_in_shader(const std::vector<BlendedTarget>& targets, Blending blending) {
    if (blending == Blending::kFixedFunction) return false;
    const DriverBlending driver = probe_blending();
    if (blending != Blending::kAutomatic && !driver.framebuffer_fetch)
        throw UserError("--blending", "the driver lacks GL_EXT_shader_framebuffer_fetch; use fixed or auto");
    if (blending != Blending::kAutomatic) return true;
    bool all = true;
    for (const BlendedTarget& t : targets) all = all && exact(t.spec.stored, driver);
    return !all && driver.framebuffer_fetch;
}

}  // namespace

std::vector<TargetSpec> specs_of(const std::vector<BlendedTarget>& targets) {
    std::vector<TargetSpec> specs;
    for (const BlendedTarget& t : targets) specs.push_back(t.spec);
    return specs;
}

BlendPass::BlendPass(Arrivals& arrivals, const std::string& technique_text, bool reads_materials,
                     std::vector<BlendedTarget> targets, Blending blending)
    : targets_(std::move(targets)), in_shader_(blends_in_shader(targets_, blending)) {
    ArrivalText text;
    text.reads_materials = reads_materials;
    if (in_shader_) {
        text.directives = "#extension GL_EXT_shader_framebuffer_fetch : require\n";
        text.text = shader_source("stored_formats");
    }
    text.text += fmt::format("#define TARGETS {}\n", targets_.size()) + technique_text +
                 main_text(targets_, in_shader_, blending == Blending::kShaderCut);
    pass_ = arrivals.pass(text);
}

void BlendPass::draw() {
    glDisable(GL_DEPTH_TEST);
    if (!in_shader_) {
        glEnable(GL_BLEND);
        for (std::size_t i = 0; i < targets_.size(); ++i) set_function(static_cast<GLuint>(i), targets_[i]);
    }
    pass_->draw();
    glDisable(GL_BLEND);
}

DriverBlending probe_blending() {
    DriverBlending driver;
    const auto* version = reinterpret_cast<const char*>(glGetString(GL_VERSION));
    driver.version = version == nullptr ? "unknown" : version;
    driver.framebuffer_fetch = epoxy_has_gl_extension("GL_EXT_shader_framebuffer_fetch");
    const ScreenPass pass("probe of blending",
                          "uniform vec4 u_value;\nlayout(location = 0) out vec4 o_target;\n"
                          "void main() { o_target = u_value; }\n");
    // What a target keeps after `times` blends of `value` over its clear value 1.
    const auto blended = [&](StoredAs stored, float value, int times) {
        const RenderTargets target({1, 1}, {{stored, 4}});
        target.bind();
        target.clear_color(0, glm::vec4(1.0f));
        glDisable(GL_DEPTH_TEST);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ZERO, GL_ONE_MINUS_SRC_COLOR);
        pass.program().set("u_value", glm::vec4(value));
        for (int i = 0; i < times; ++i) pass.draw();
        glDisable(GL_BLEND);
        return target.read(0)[0];
    };
    // 1 - 0.3 * 2^-11 lies nearer to 1 than to the half below it, 1 - 2^-11.
    driver.rounds_float16 = blended(StoredAs::kFloat16, 0.3f / 2048, 1) == 1.0f;
    // Ten times 10.4 codes: a source that is rounded first takes 10 of them each time.
    const auto exact_codes = [&](StoredAs stored, float codes) {
        float value = 1.0f;
        for (int i = 0; i < 10; ++i) value = std::round((1.0f - 10.4f / codes) * value * codes) / codes;
        return blended(stored, 10.4f / codes, 10) == value;
    };
    driver.exact_unorm8 = exact_codes(StoredAs::kUnorm8, 255);
    driver.exact_snorm8 = exact_codes(StoredAs::kSnorm8, 127);
    return driver;
}

std::string DriverBlending::summary() const {
    return fmt::format(
        "stores of float16 {}, blends into unorm8 {}, into snorm8 {}; blending in the shader {}",
        rounds_float16 ? "round to nearest" : "are cut off",
        exact_unorm8 ? "round once" : "round their source too",
        exact_snorm8 ? "round once" : "do not round to nearest",
        framebuffer_fetch ? "is offered" : "is not offered");
}

}  // namespace ropsim
