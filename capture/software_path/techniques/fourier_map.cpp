// Fourier opacity maps as transparency.
#include "base/error.h"
#include "capture/software_path/visibility_maps.h"

namespace ropsim {

std::unique_ptr<SoftwareTechnique> make_software_fourier_map(Parameters& parameters, const TraceHeader&) {
    const std::int64_t coefficients = parameters.get_integer("coefficients", 7, 1, 31);
    if (coefficients % 2 == 0)
        throw UserError(parameters.where("coefficients"), "a mean and pairs are an odd number");
    const auto guard = static_cast<float>(parameters.get_real("guard", 0.0, 0.0, 0.45));
    std::string defines;
    if (guard > 0)
        defines += fmt::format("#define GUARDED\n#define GUARD {:.9e}\n#define UNGUARDED {:.9e}\n", guard,
                               1.0f - 2.0f * guard);
    if (parameters.get_choice("clamp", "on", {"on", "off"}) == "on") defines += "#define CLAMPED\n";
    return make_visibility_map(parameters, "fourier_map", "coefficients", StoredAs::kFloat16, coefficients,
                               defines);
}

}  // namespace ropsim
