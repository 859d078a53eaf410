// `ropsim stress`: how stable techniques are, in every stored format.
#include "analysis/standard_techniques.h"
#include "analysis/stress/stress_page.h"
#include "analysis/stress/stress_search.h"
#include "analysis/stress/stress_study.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "capture/scene_list.h"
#include "cli/commands.h"
#include "cli/study_options.h"

#include <array>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct StressOptions {
    std::vector<std::string> techniques;
    std::vector<std::string> scenes;
    std::string directory;
    std::uint64_t seed = 0;
    int threads = default_threads();
    bool quick = false;
    bool every_format = false;
    bool no_scenes = false;
    bool json = false;
    std::string page;
    bool worst = false;
    std::uint64_t evaluations = StressSearch{}.evaluations;
    std::uint64_t random = 0;
};

// Read before anything is run, so that a misspelt name or a mark that is missing costs nothing.
std::string page_text(const StressOptions& options, std::span<const std::string_view> blocks) {
    if (options.page.empty()) return "";
    std::string text = read_file(options.page);
    check_stress_page(text, options.page, blocks);
    return text;
}
void renew_page(const StressOptions& options, const std::string& text,
                const std::vector<StressBlock>& blocks) {
    if (!options.page.empty()) write_file(options.page, with_stress_blocks(text, options.page, blocks));
}

void run_search(const StressOptions& options) {
    const StressSearch search{options.techniques.empty() ? techniques_at_defaults() : options.techniques,
                              options.evaluations, options.random, options.seed, options.threads};
    for (const std::string& technique : search.techniques)
        StressedPixel(technique, options.seed);  // or is refused
    const std::string page = page_text(options, std::array<std::string_view, 1>{"worst"});
    start_directory(options.directory, {"worst.json", "worst.md"});
    const std::vector<WorstPixel> pixels = search_worst_pixels(search);
    const std::string markdown = worst_pixels_markdown(pixels);
    write_file(options.directory + "/worst.md", markdown);
    const std::string json = worst_pixels_json(pixels);
    write_file(options.directory + "/worst.json", json);
    renew_page(options, page, {{"worst", markdown}});
    fmt::print("{}", options.json ? json : markdown);
    fmt::print(stderr, "{}/worst.json\n", options.directory);
}

void run_matrix(const StressOptions& options) {
    StressInputOptions inputs;
    inputs.seed = options.seed;
    inputs.scenes = options.scenes;
    if (options.scenes.empty() && !options.quick && !options.no_scenes)
        for (const SceneInfo& scene : scene_list()) inputs.scenes.emplace_back(scene.name);
    if (options.quick) {
        inputs.layers = {1, 10, 100, 1000};
        inputs.trace_pixels = 8;
    }
    std::vector<StressTechnique> techniques =
        stress_techniques(options.techniques.empty() ? stress_configurations() : options.techniques,
                          !options.quick || options.every_format);
    const std::string page = page_text(options, kStressMatrixBlocks);
    start_directory(options.directory, {"stress.json", "stress.csv", "stress.md"});
    const StressStudy study =
        run_stress_study(std::move(techniques), stress_inputs(inputs), options.seed, options.threads);
    write_file(options.directory + "/stress.csv", stress_csv(study));
    const std::string markdown = stress_markdown(study);
    write_file(options.directory + "/stress.md", markdown);
    const std::string json = stress_json(study);
    write_file(options.directory + "/stress.json", json);
    renew_page(options, page, stress_blocks(study));
    fmt::print("{}", options.json ? json : markdown);
    fmt::print(stderr, "{}/stress.json\n", options.directory);
    if (const StressFaults faults = study.faults(); faults.all() > 0)
        throw UserError(
            "stress",
            fmt::format("{} values are none in formats that hold what is declared: see {}/stress.md",
                        faults.all(), options.directory));
}

}  // namespace

void add_stress_command(CLI::App& app) {
    const auto options = std::make_shared<StressOptions>();
    CLI::App* command = app.add_subcommand(
        "stress", "How stable techniques are: every stored format on every stress trace and scene");
    add_technique_option(*command, options->techniques,
                         "NAME[:key=value,...], repeatable; default: every technique in its configurations "
                         "(with --worst: at its headline parameters)");
    command->add_option("--scene", options->scenes,
                        "scene to capture and take pixels of, repeatable; default: every one");
    command->add_flag("--no-scenes", options->no_scenes, "stress traces and series of layers alone");
    command->add_flag("--quick", options->quick,
                      "paper's formats and float32 alone, no scenes, up to 1,000 layers");
    command->add_flag("--every-format", options->every_format,
                      "with --quick: every stored format all the same");
    CLI::Option* worst = command->add_flag(
        "--worst", options->worst,
        "instead, search for each technique's worst pixel, by random pixels and evolution from them");
    command->add_option("--evaluations", options->evaluations, "of the search, for each technique and goal")
        ->needs(worst)
        ->check(CLI::Range(std::uint64_t{100}, std::uint64_t{1} << 40));
    command
        ->add_option("--random", options->random,
                     "fragments of random pixels to hold against the worst found, for each technique")
        ->needs(worst)
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 40));
    command->add_option("--seed", options->seed, "of the inputs and of the techniques' randomness");
    command->add_option("--threads", options->threads, "threads on the host; results do not depend on it")
        ->check(CLI::Range(1, 1024));
    command->add_option("--page", options->page,
                        "page (docs/stability.md) whose marked tables are renewed: with --worst that of the "
                        "worst pixels, else the others");
    command->add_flag("--json", options->json, "print stress.json instead of the tables");
    command
        ->add_option("-o,--output", options->directory,
                     "directory of stress.json, .csv and .md, or of worst.json and .md")
        ->required();
    command->footer(
        "Rounding is the difference to the same operation in double precision without stored formats, error "
        "the\ndifference to exact compositing; both of a channel, relative to the pixel's brightest colour "
        "(at least 1).\nTables are in units of 1/255 of it.");
    command->callback([options] {
        if (options->worst)
            run_search(*options);
        else
            run_matrix(*options);
    });
}

}  // namespace ropsim
