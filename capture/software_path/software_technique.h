// A technique of the software path: one file in software_path/techniques/, its GLSL beside the other shaders,
// and one line in techniques.def.
#pragma once

#include "base/parameters.h"
#include "capture/software_path/arrivals.h"
#include "capture/software_path/blending.h"
#include "traces/image.h"

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace ropsim {

struct SoftwareOptions {
    std::uint64_t seed = 0;
    Blending blending = Blending::kAutomatic;
};

struct SoftwareImage {
    Image image;            // R, G, B
    std::string rendering;  // how: "fixed-function blending", "3 passes, 4x MSAA", ...
    // Where functions occur that drivers approximate (exp, log, pow): how far the image may be off,
    // absolutely, for 1e-6 absolute on each of their values. 0: only + - x / and compares.
    double function_bound = 0;
};

class SoftwareTechnique {
 public:
    virtual ~SoftwareTechnique() = default;
    virtual SoftwareImage render(Arrivals& arrivals, const SoftwareOptions& options) = 0;
};

// Reads the technique's keys as the model does; a key that the software path does not know stays unread, so
// that parameters.close() refuses it. `header`: of the frame to be drawn.
using MakeSoftwareTechnique = std::unique_ptr<SoftwareTechnique> (*)(Parameters& parameters,
                                                                     const TraceHeader& header);
struct SoftwareTechniqueInfo {
    std::string_view name;  // the model's
    MakeSoftwareTechnique make;
};
const std::vector<SoftwareTechniqueInfo>& software_techniques();

// How a surface is stored: format=paper or float32, and the surface's own `<surface>_format`.
StoredAs stored_by(Parameters& parameters, const std::string& surface, StoredAs paper);
// Four floats a pixel, as an image of R, G and B; a display takes infinity for the largest half.
Image image_of(int width, int height, const std::vector<float>& rgba);
// GLSL of a resolve: `shader` defines `vec3 resolved(ivec2 pixel)`, and may use what arrival.glsl declares
// but arrival(). The image is kept as `stored` keeps it. `declarations`: another shader file before it.
std::string resolve_text(const char* shader, StoredAs stored, const std::string& defines = {},
                         const char* declarations = nullptr);
// The same of several shader files, one behind the other, of which the last defines resolved().
std::string resolve_text(const std::vector<const char*>& shaders, StoredAs stored,
                         const std::string& defines = {});
// A line that defines the macro name(v), of a float or vec4: what is kept of v as `stored`. `saturated`:
// large values become binary16's largest, where they would be infinite.
std::string keeping(const char* name, StoredAs stored, bool saturated = true);
// Draws such a pass over every pixel.
Image resolved_image(const Arrivals& arrivals, const ScreenPass& pass);

}  // namespace ropsim
