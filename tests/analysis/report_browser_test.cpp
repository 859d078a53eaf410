// Reports used in headless Chromium, by clicks and keys, at two widths (report_browser.py); here the pages
// are made.
#include "analysis/child_process.h"
#include "analysis/report/report_rows.h"
#include "analysis/report/report_validation.h"
#include "analysis/report/report_widgets.h"
#include "base/atomic_file.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr int kNotInstalled = 77;
constexpr std::size_t kPixels = std::size_t{96} * 64;  // of the validation

class ReportBrowser : public ScratchTest {
 protected:
    // Uses the page as `kind` is used. ROPSIM_SHOTS=DIR keeps pictures of it.
    static void use(const std::string& kind, const std::string& page, std::vector<std::string> more = {}) {
        const std::string script = std::string(ROPSIM_SOURCE_DIR) + "/tests/analysis/report_browser.py";
        std::vector<std::string> command{"/usr/bin/python3", "-B", script, kind, page};
        command.insert(command.end(), more.begin(), more.end());
        if (const char* shots = std::getenv("ROPSIM_SHOTS"))
            command.insert(command.end(), {"--shots", shots});
        // What holds and what does not goes to stdout, which a child's is not kept of.
        std::string line = shell_line(command) + " >&2";
        const ChildResult result = run_child({"/bin/sh", "-c", line});
        if (result.exit_code == kNotInstalled)
            GTEST_SKIP()
                << "chromium, chromium-driver or python3-selenium is missing (./install_packages --check)";
        EXPECT_EQ(result.exit_code, 0) << result.error_output;
    }
};

TEST_F(ReportBrowser, Compare) {
    const std::string trace = path("random.trace");
    RandomFragments options;
    options.width = 320;
    options.height = 176;
    options.count = 200'000;
    const auto fragments = random_fragments(options);
    write_trace(trace, random_header(options), fragments);
    const Fragment& first = fragments.front();
    const auto here = std::count_if(fragments.begin(), fragments.end(),
                                    [&](const Fragment& f) { return f.x == first.x && f.y == first.y; });
    const std::string pixel = fmt::format("{},{}", first.x, first.y);
    const std::string directory = path("compare");
    const ChildResult made =
        run_child({ROPSIM_PROGRAM, "compare", trace, "--technique", "alpha_blend", "--technique", "a_buffer",
                   "--technique", "adaptive:nodes=4", "--technique", "weighted_blended", "--technique",
                   "stochastic:samples=4", "--inspect", pixel, "-o", directory});
    ASSERT_EQ(made.exit_code, 0) << made.error_output;
    use("compare", directory + "/report.html", {"--pixel", pixel, "--fragments", std::to_string(here)});
}

TEST_F(ReportBrowser, Claims) {
    std::string rows = "[";
    for (int i = 0; i < 12; ++i)
        rows += fmt::format(
            R"({}{{"id": "claim-{}", "paper": "Paper {}", "place": "section {}", "claim": "{} of a fragment, as a sentence that is long enough to need more than one line in a narrow column", "printed": {}, "worst_case": {}, "measured": {}, "verdict": "{}", "why": {}}})",
            i ? "," : "", i, i % 3, i, i % 2 ? "bandwidth" : "storage", 16 + i, 17 + i,
            i == 5 ? "null" : std::to_string(40 - 3 * i),
            i % 4 == 0 ? "does not follow from its own definition" : "reproduced",
            i % 4 == 0 ? "\"the paper counts samples, not pixels\"" : "null");
    write_file(path("claims.html"), claims_report(rows + "]", "ropsim claims --json"));
    use("claims", path("claims.html"));
}

TEST_F(ReportBrowser, Bench) {
    std::string rows;
    for (int i = 0; i < 9; ++i)
        rows += fmt::format(R"({}["run {}", "{}", {}, {}, {}])", i ? "," : "", i,
                            i % 3 == 0   ? "count"
                            : i % 3 == 1 ? "cached"
                                         : "timed",
                            0.1 * (i + 1) * (i + 1), (i * 7 % 9) + 0.5, 100.0 / (i + 1));
    write_file(path("bench.html"), bench_report(R"({"plots": [{"title": "Runs", "x": "seconds", "y": "error",
                                "columns": ["name", "fidelity", "seconds", "error", "speed"], "rows": [)" +
                                                    rows + "]}]}",
                                                "ropsim bench --json"));
    use("bench", path("bench.html"));
}

// Fronts of scenes apart: what one scene takes says nothing about another.
TEST_F(ReportBrowser, PlotOfScenes) {
    ReportPlot plot{"plot",    "caption", {{"seconds"}, {"error"}, {"speed"}}, {"scene"}, {},
                    "seconds", "error"};
    plot.within = "scene";
    for (int i = 0; i < 12; ++i)
        plot.points.push_back({fmt::format("point {}", i),
                               {i % 2 ? "easy" : "hard"},
                               {1.0 + i * 5 % 12, (i % 2 ? 1.0 : 10.0) + i * 7 % 12, 1.0 + i}});
    ReportPage page("Scenes", "");
    ReportSection section{"scenes", "Scenes"};
    section += report_plot(plot);
    page.add(std::move(section));
    page.write(path("scenes.html"));
    use("bench", path("scenes.html"));
}

TEST_F(ReportBrowser, Validate) {
    Validation validation;
    validation.options.directory = path("");
    validation.width = 96;
    validation.height = 64;
    validation.renderer = "a driver";
    for (const char* name : {"adaptive", "alpha_blend", "a_buffer"}) {
        ValidatedTechnique technique;
        technique.technique = name;
        technique.picture = fmt::format("difference-{}.png", name);
        technique.agreement.pixels = kPixels;
        const bool differs = technique.technique == "a_buffer";
        const std::size_t apart = differs ? 1000 : technique.technique == "adaptive" ? 3 : 0;
        technique.agreement.equal = technique.agreement.within = kPixels - apart;
        technique.agreement.bound.within_share = technique.agreement.bound.equal_share = 0.99;
        validation.techniques.push_back(technique);
        Image model(96, 64, {"R", "G", "B"});
        for (std::size_t i = 0; i < model.values.size(); ++i)
            model.values[i] =
                static_cast<float>(i % 97) / 96 / static_cast<float>(validation.techniques.size());
        Image drawn = model;
        for (std::size_t i = 0; i < drawn.values.size(); i += differs ? 5 : 500) drawn.values[i] += 0.25f;
        write_exr(
            path(fmt::format("difference-{}.exr", name)),
            difference_channels(model, drawn, std::vector<PixelKind>(kPixels, PixelKind::kSameFragments),
                                Format::kFloat16));
    }
    ValidatedTechnique refused;
    refused.technique = "z3";
    refused.failure = "needs more than one spatial sample";
    validation.techniques.push_back(refused);
    write_file(path("report.html"), validation_report(validation, "ropsim validate scene -o out"));
    use("validate", path("report.html"));
}

}  // namespace
}  // namespace ropsim
