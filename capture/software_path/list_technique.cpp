#include "capture/software_path/list_technique.h"

#include "base/error.h"

namespace ropsim {
namespace {

class ListPass : public SoftwareTechnique {
 public:
    explicit ListPass(ListTechnique technique) : technique_(std::move(technique)) {}

    SoftwareImage render(Arrivals& arrivals, const SoftwareOptions& options) override {
        const std::string defines =
            technique_.defines +
            fmt::format("#define SAMPLES {}u\n", static_cast<unsigned>(arrivals.samples()));
        return {image_from_lists(arrivals, technique_.shaders, technique_.image, defines, options.seed),
                "pass over lists", 0};
    }

 private:
    ListTechnique technique_;
};

}  // namespace

std::unique_ptr<SoftwareTechnique> make_list_technique(ListTechnique technique) {
    return std::make_unique<ListPass>(std::move(technique));
}

StoredAs stored_image(Parameters& parameters) {
    return stored_by(parameters, "image", StoredAs::kFloat16);
}
void read_exact_depth(Parameters& parameters, const char* surface) {
    if (stored_by(parameters, surface, StoredAs::kFloat32) != StoredAs::kFloat32)
        throw UserError(parameters.where(fmt::format("{}_format", surface)),
                        "the software path compares depths as float32; leave it out");
}
void check_one_sample(const char* technique, const TraceHeader& header) {
    if (header.samples > 1)
        throw UserError("--technique",
                        fmt::format("{} takes traces of one sample a pixel, and this one has {}", technique,
                                    header.samples));
}

}  // namespace ropsim
