#include "capture/software_path/software_technique.h"

#include "capture/shader_sources.h"

#include <cmath>

#include <fmt/format.h>

namespace ropsim {

#define TECHNIQUE(name)                                                             \
    std::unique_ptr<SoftwareTechnique> make_software_##name(Parameters& parameters, \
                                                            const TraceHeader& header);
#include "capture/software_path/techniques.def"
#undef TECHNIQUE

const std::vector<SoftwareTechniqueInfo>& software_techniques() {
    static const std::vector<SoftwareTechniqueInfo> list = {
#define TECHNIQUE(name) {#name, make_software_##name},
#include "capture/software_path/techniques.def"
#undef TECHNIQUE
    };
    return list;
}

StoredAs stored_by(Parameters& parameters, const std::string& surface, StoredAs paper) {
    const bool exact = parameters.get_choice("format", "paper", {"paper", "float32"}) == "float32";
    const std::string key = surface + "_format";
    const std::string name = parameters.get_string(key, stored_name(exact ? StoredAs::kFloat32 : paper));
    return stored_as(name, parameters.has(key) ? parameters.where(key) : key);
}

namespace {
constexpr float kBrightest = 65504.0f;  // the largest half
}

Image image_of(int width, int height, const std::vector<float>& rgba) {
    Image image(width, height, {"R", "G", "B"});
    for (std::size_t i = 0; i < rgba.size() / 4; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            const float value = rgba[4 * i + c];
            image.values[3 * i + c] = std::isinf(value) ? std::copysign(kBrightest, value) : value;
        }
    return image;
}

std::string resolve_text(const std::vector<const char*>& shaders, StoredAs stored,
                         const std::string& defines) {
    std::string text =
        defines + std::string(shader_source("arrival")) + std::string(shader_source("stored_formats"));
    for (const char* shader : shaders) text += shader_source(shader);
    return text + fmt::format(
                      "layout(location = 0) out vec4 o_color;\n"
                      "void main() {{ o_color = kept_{}(vec4(resolved(ivec2(gl_FragCoord.xy)), 1.0)); }}\n",
                      stored_name(stored));
}
std::string resolve_text(const char* shader, StoredAs stored, const std::string& defines,
                         const char* declarations) {
    if (declarations == nullptr) return resolve_text(std::vector{shader}, stored, defines);
    return resolve_text({declarations, shader}, stored, defines);
}

std::string keeping(const char* name, StoredAs stored, bool saturated) {
    return fmt::format("#define {}(v) kept_{}({})\n", name, stored_name(stored),
                       saturated && stored == StoredAs::kFloat16 ? "clamp(v, -65504.0, 65504.0)" : "v");
}

Image resolved_image(const Arrivals& arrivals, const ScreenPass& pass) {
    const RenderTargets target({arrivals.width(), arrivals.height()}, {{StoredAs::kFloat32, 4}});
    target.bind();
    glDisable(GL_DEPTH_TEST);
    arrivals.set_shared(pass.program());
    arrivals.bind_shared();
    pass.draw();
    return image_of(arrivals.width(), arrivals.height(), target.read(0));
}

}  // namespace ropsim
