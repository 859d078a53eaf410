#include "analysis/validation.h"

#include "analysis/pixel_run.h"
#include "analysis/standard_techniques.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "capture/capture.h"
#include "capture/gl_context.h"
#include "capture/software_path/fragment_prints.h"
#include "capture/software_path/software_technique.h"
#include "model/run.h"
#include "traces/trace_layout.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <filesystem>
#include <fstream>

namespace ropsim {
namespace {

bool is_trace(const std::string& path) {
    if (path.ends_with(".trace")) return true;
    if (!std::filesystem::is_regular_file(path)) return false;
    std::ifstream file(path, std::ios::binary);
    std::string start(kTraceMagic.size(), '\0');
    file.read(start.data(), static_cast<std::streamsize>(start.size()));
    return start == kTraceMagic;
}

CaptureOptions capture_options(const ValidationOptions& o) {
    CaptureOptions capture;
    capture.scene_or_file = o.input;
    capture.size = o.size;
    capture.samples = o.samples;
    capture.fragments = o.fragments;
    capture.seed = o.scene_seed;
    // The values that the shaders made, so that both sides start from the same bits.
    capture.color_storage = ColorStorage::kFloat32;
    return capture;
}

std::vector<std::string> all_techniques() {
    std::vector<std::string> all;
    for (const SoftwareTechniqueInfo& info : software_techniques())
        for (const char* format : {"paper", "float32"})
            // A round of peeling draws all fragments: without a limit, hundreds of times.
            all.push_back(fmt::format("{}:{}format={}", info.name,
                                      info.name == "depth_peeling" ? "layers=16," : "", format));
    return all;
}

std::unique_ptr<SoftwareTechnique> make_technique(const std::string& text, const TraceHeader& header) {
    TechniqueSpec spec = parse_technique(text, "--technique");
    std::string names;
    for (const SoftwareTechniqueInfo& info : software_techniques()) {
        names += (names.empty() ? "" : ", ") + std::string(info.name);
        if (info.name != spec.name) continue;
        auto technique = info.make(spec.parameters, header);
        spec.parameters.close();
        return technique;
    }
    throw UserError("--technique", fmt::format("the software path has no '{}'; it has {}", spec.name, names));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string file_stem(std::string technique) {
    for (char& c : technique)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '=' && c != '-') c = '-';
    return technique;
}

class Validator {
 public:
    Validator(const ValidationOptions& options, const std::string& trace, Arrivals& arrivals)
        : options_(options), trace_path_(trace), trace_(trace), arrivals_(arrivals), lists_(arrivals) {}

    // Before the first run.
    void compare_fragments(Validation& validation);
    ValidatedTechnique run(const std::string& technique);

 private:
    void explain(const Image& model, const Image& drawn, ValidatedTechnique& result);
    DifferingPixel pixel_at(int x, int y, const Image& model, const Image& drawn);

    const ValidationOptions& options_;
    std::string trace_path_;
    TraceReader trace_;
    Arrivals& arrivals_;
    GpuFragmentLists lists_;
    // Tiles that nothing is drawn to are left out: the model leaves the opaque layer there as it is, and does
    // not put it through the technique's formats.
    std::vector<PixelKind> kinds_;
};

ValidatedTechnique Validator::run(const std::string& technique) {
    ValidatedTechnique result;
    result.technique = technique;
    const auto software = make_technique(technique, trace_.header());
    auto start = std::chrono::steady_clock::now();
    RunOptions run;
    run.trace = trace_path_;
    run.technique = technique;
    run.fidelity = Fidelity::kCount;
    run.seed = options_.seed;
    run.threads = options_.threads;
    run.error = false;
    const RunResult model = run_simulation(run);
    result.model_seconds = seconds_since(start);
    start = std::chrono::steady_clock::now();
    const SoftwareImage drawn = software->render(arrivals_, {options_.seed, options_.blending});
    result.drawing_seconds = seconds_since(start);
    result.rendering = drawn.rendering;
    const Format stored = model.declaration.image_format;
    result.agreement = compare_images(model.image, drawn.image, kinds_, stored, drawn.function_bound);
    explain(model.image, drawn.image, result);
    result.picture = "difference-" + file_stem(technique) + ".png";
    const std::string path = options_.directory + "/difference-" + file_stem(technique);
    write_png(path + ".png", difference_picture(model.image, drawn.image, kinds_, stored));
    write_exr(path + ".exr", difference_channels(model.image, drawn.image, kinds_, stored));
    return result;
}

DifferingPixel Validator::pixel_at(int x, int y, const Image& model, const Image& drawn) {
    DifferingPixel pixel;
    pixel.x = x;
    pixel.y = y;
    for (std::size_t c = 0; c < 3; ++c) {
        pixel.model[c] = model.pixel(x, y)[c];
        pixel.drawn[c] = drawn.pixel(x, y)[c];
    }
    pixel.model_fragments = read_pixel(trace_, x, y).fragments;
    pixel.drawn_fragments = lists_.at(x, y);
    return pixel;
}

void Validator::explain(const Image& model, const Image& drawn, ValidatedTechnique& result) {
    const auto& first = result.agreement.first;
    if (first) result.first = pixel_at(first->x, first->y, model, drawn);
}

void Validator::compare_fragments(Validation& validation) {
    const std::vector<std::uint8_t> touched = lists_.touched_tiles();
    const std::vector<std::uint64_t> drawn = drawn_fragment_prints(arrivals_);
    const std::vector<std::uint64_t> traced = traced_fragment_prints(trace_);
    kinds_.assign(touched.size(), PixelKind::kLeftOut);
    for (std::size_t i = 0; i < touched.size(); ++i) {
        validation.covered += drawn[i] != 0 || traced[i] != 0;
        validation.other_fragments += drawn[i] != traced[i];
        if (touched[i] != 0)
            kinds_[i] = drawn[i] == traced[i] ? PixelKind::kSameFragments : PixelKind::kOtherFragments;
    }
}

}  // namespace

bool same_fragments(const DifferingPixel& pixel) {
    const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
    return std::equal(
        pixel.model_fragments.begin(), pixel.model_fragments.end(), pixel.drawn_fragments.begin(),
        pixel.drawn_fragments.end(), [&](const Fragment& f, const ListedFragment& l) {
            return bits(f.z) == bits(l.z) && bits(f.a) == bits(l.alpha) &&
                   bits(f.r) == bits(l.premultiplied[0]) && bits(f.g) == bits(l.premultiplied[1]) &&
                   bits(f.b) == bits(l.premultiplied[2]) && f.primitive == l.primitive &&
                   (static_cast<std::uint32_t>(f.draw) << 16 | f.coverage) == l.coverage_draw;
        });
}

std::string ValidatedTechnique::cause() const {
    const Agreement& a = agreement;
    if (!failure.empty() || a.equal == a.pixels) return "";
    const std::uint64_t outside = a.pixels - a.within;
    if (outside == 0 && !a.holds()) return "last bit, at too many pixels";
    if (outside == 0) return a.unequal_excused == a.pixels - a.equal ? "other fragments" : "last bit";
    if (a.outside_excused == outside) return fmt::format("{} pixels of other fragments", outside);
    return fmt::format("the operation or the driver's blending at {} pixels", outside - a.outside_excused);
}

bool Validation::holds() const {
    return std::none_of(techniques.begin(), techniques.end(), [](const auto& t) { return t.differs(); });
}

namespace {

Validation describe(const ValidationOptions& options, const TraceReader& trace, const GlContext& context) {
    Validation validation;
    validation.options = options;
    validation.renderer = context.renderer();
    validation.driver = probe_blending();
    validation.scene = trace.header().scene;
    validation.trace_hash = trace.hash();
    validation.width = trace.header().width;
    validation.height = trace.header().height;
    validation.samples = trace.header().samples;
    validation.fragments = trace.fragment_count();
    return validation;
}

}  // namespace

Validation run_validation(const ValidationOptions& options,
                          const std::function<void(const std::string&)>& progress) {
    const bool scene = !is_trace(options.input);
    if (!scene && (options.size || options.fragments || options.samples != 1))
        throw UserError(options.input,
                        "is a trace, which has its size, samples and fragments already; leave out "
                        "--size, --samples and --fragments");
    const std::vector<std::string> techniques =
        options.techniques.empty() ? all_techniques() : options.techniques;
    start_directory(options.directory, {"validation.json", "validation.md", "report.html"});
    const std::string trace_path = scene ? options.directory + "/scene.trace" : options.input;
    const CaptureOptions capture = capture_options(options);
    if (scene) {
        keep_inputs({options.input}, {trace_path});
        if (progress) progress("capturing " + options.input);
        capture_scene(capture, trace_path);
    }
    const GlContext context;
    TraceReader trace(trace_path);
    Validation validation = describe(options, trace, context);
    // A misspelt technique, or one that cannot take this trace, is to be refused before hours of drawing.
    for (const std::string& technique : options.techniques) {
        make_technique(technique, trace.header());
        if (const std::string why = refusal(technique, trace.header()); !why.empty())
            throw UserError("--technique " + technique, why);
    }
    std::optional<Scene> geometry;
    if (scene && !options.replay && validation.samples == 1)
        geometry = build_scene(find_scene(capture), capture);
    const std::unique_ptr<Arrivals> arrivals =
        geometry ? geometry_arrivals(*geometry, trace.header()) : replayed_arrivals(trace);
    validation.drawn = arrivals->kind();
    Validator validator(options, trace_path, *arrivals);
    validator.compare_fragments(validation);
    for (const std::string& technique : techniques) {
        // What nobody asked for may be beyond the trace.
        const std::string refused =
            options.techniques.empty() ? refusal(technique, trace.header()) : std::string();
        if (!refused.empty()) {
            validation.techniques.emplace_back().technique = technique;
            validation.techniques.back().failure = refused;
            continue;
        }
        if (progress) progress(technique);
        validation.techniques.push_back(validator.run(technique));
    }
    write_file(options.directory + "/validation.md", validation_markdown(validation));
    write_file(options.directory + "/validation.json", validation_json(validation));
    return validation;
}

}  // namespace ropsim
