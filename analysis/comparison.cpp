// Techniques on traces, a run each.
#include "analysis/comparison.h"

#include "analysis/run_pool.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "rop/reference.h"

#include <cctype>
#include <filesystem>
#include <set>

#include <fmt/format.h>

namespace ropsim {
namespace {

namespace fs = std::filesystem;

ComparisonOfOneTrace open_trace(const std::string& file, const std::string& name) {
    TraceReader reader(file);
    ComparisonOfOneTrace comparison;
    comparison.trace = file;
    comparison.name = name;
    comparison.scene = reader.header().scene;
    comparison.hash = reader.hash();
    comparison.width = reader.header().width;
    comparison.height = reader.header().height;
    comparison.samples = reader.header().samples;
    comparison.fragments = static_cast<double>(reader.fragment_count());
    // Before the runs, so that they find it in the cache instead of all computing it.
    comparison.reference = cached_reference_image(reader, default_threads());
    return comparison;
}

void refuse_repetitions(const std::vector<std::string>& techniques) {
    std::set<std::string> seen;
    for (const std::string& technique : techniques)
        if (!seen.insert(technique).second)
            throw UserError("--technique", fmt::format("'{}' is given twice; leave one out", technique));
}

}  // namespace

std::vector<std::string> default_techniques() {
    return {"alpha_blend",          "a_buffer",
            "stochastic:samples=8", "laine_karras:samples=8",
            "adaptive:nodes=8",     "slab:layers=8,bits=16"};
}

std::vector<std::string> slugs(const std::vector<std::string>& names) {
    std::vector<std::string> result;
    std::set<std::string> used;
    for (const std::string& name : names) {
        std::string slug;
        for (const char c : name) {
            const bool keep =
                std::isalnum(static_cast<unsigned char>(c)) || c == '_' || (c == '.' && !slug.empty());
            if (keep)
                slug += c;
            else if (!slug.empty() && slug.back() != '-')
                slug += '-';
        }
        while (slug.ends_with('-')) slug.pop_back();
        if (slug.empty()) slug = "run";
        std::string unique = slug;
        for (int n = 2; !used.insert(unique).second; ++n) unique = fmt::format("{}-{}", slug, n);
        result.push_back(unique);
    }
    return result;
}

std::vector<ComparisonOfOneTrace> run_comparison(const ComparisonOptions& options) {
    const auto techniques = options.techniques.empty() ? default_techniques() : options.techniques;
    refuse_repetitions(techniques);
    const auto technique_slugs = slugs(techniques);
    std::vector<std::string> stems;
    for (const std::string& trace : options.traces) stems.push_back(fs::path(trace).stem().string());
    const auto trace_slugs = slugs(stems);

    std::vector<ComparisonOfOneTrace> comparisons;
    for (std::size_t t = 0; t < options.traces.size(); ++t) {
        comparisons.push_back(open_trace(options.traces[t], trace_slugs[t]));
        fs::path directory = options.directory;
        if (options.traces.size() > 1) directory /= trace_slugs[t];
        start_directory(directory.string());
        for (std::size_t i = 0; i < techniques.size(); ++i) {
            RunRecord run;
            run.technique = techniques[i];
            run.directory = (directory / technique_slugs[i]).string();
            run.command = {"ropsim", "run", options.traces[t], "--technique", techniques[i]};
            run.command.insert(run.command.end(), options.run_options.begin(), options.run_options.end());
            run.command.insert(run.command.end(), {"-o", run.directory});
            comparisons.back().runs.push_back(std::move(run));
        }
    }

    std::vector<PooledRun> queue;
    for (ComparisonOfOneTrace& comparison : comparisons)
        for (RunRecord& run : comparison.runs)
            queue.push_back({&run, fmt::format("{} {}", comparison.name, run.technique)});
    run_all(queue, {options.threads, options.program, options.unwanted});
    return comparisons;
}

}  // namespace ropsim
