// One functional run for each technique, value and seed.
#include "analysis/convergence.h"

#include "analysis/progress.h"
#include "base/error.h"
#include "base/parallel.h"
#include "model/run.h"
#include "rop/reference.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

namespace ropsim {
namespace {

std::string with_value(const std::string& technique, const std::string& key, const std::string& value) {
    return fmt::format("{}{}{}={}", technique, technique.find(':') == std::string::npos ? ":" : ",", key,
                       value);
}

double positive_number(const std::string& text) {
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || rest != end || !std::isfinite(value) || value <= 0)
        throw UserError("--values",
                        fmt::format("'{}' is not a number above 0; a log-log slope needs such", text));
    return value;
}

std::vector<ConvergenceAtValue> ascending(const std::vector<std::string>& texts) {
    std::vector<ConvergenceAtValue> values;
    for (const std::string& text : texts) {
        values.emplace_back();
        values.back().text = text;
        values.back().value = positive_number(text);
    }
    const auto before = [](const auto& a, const auto& b) { return a.value < b.value; };
    std::sort(values.begin(), values.end(), before);
    for (std::size_t i = 1; i < values.size(); ++i)
        if (values[i].value == values[i - 1].value)
            throw UserError("--values", fmt::format("{} is given twice; leave one out", values[i].text));
    return values;
}

// The technique with each value made once: what it refuses, it refuses here.
ConvergenceOfTechnique checked(const std::string& technique, const ConvergenceOptions& options,
                               const Screen& screen) {
    if (parse_technique(technique, "--technique").parameters.has(options.key))
        throw UserError("--technique", fmt::format("'{}' sets {}, which --values runs through; leave it out",
                                                   technique, options.key));
    ConvergenceOfTechnique result;
    result.technique = technique;
    result.values = ascending(options.values);
    for (ConvergenceAtValue& at : result.values) {
        const std::string text = with_value(technique, options.key, at.text);
        try {
            TechniqueSpec spec = parse_technique(text, "--technique");
            const Declaration declaration = make_operation(spec, screen)->declaration();
            at.storage_bits_per_pixel = declaration.storage_bits_per_pixel();
            result.random = declaration.random;
            for (const auto& [key, resolved] : spec.parameters.resolved())
                if (key != options.key) result.parameters[key] = resolved.value;
        } catch (const UserError& error) {
            throw UserError(text, fmt::format("{}: {}", error.where(), error.what()));
        }
    }
    return result;
}

Convergence prepared(const ConvergenceOptions& options, const TraceReader& trace) {
    const TraceHeader& header = trace.header();
    Convergence result{options,       trace.hash(),   header.scene,           header.width,
                       header.height, header.samples, trace.fragment_count(), {}};
    const Screen screen = screen_of(header, 1);
    std::set<std::string> seen;
    for (const std::string& technique : options.techniques) {
        if (!seen.insert(technique).second)
            throw UserError("--technique", fmt::format("'{}' is given twice; leave one out", technique));
        result.techniques.push_back(checked(technique, options, screen));
    }
    return result;
}

ConvergenceRun one_run(const ConvergenceOptions& options, const std::string& technique, std::uint64_t seed,
                       int threads) {
    RunOptions run;
    run.trace = options.trace;
    run.technique = technique;
    run.fidelity = Fidelity::kCount;
    run.seed = seed;
    run.threads = threads;
    const RunResult result = run_simulation(run);
    CHECK(result.error.has_value());
    std::uint64_t worst = 0;
    std::uint64_t touched = 0;
    for (const SurfaceTraffic& t : result.traffic) {
        worst += t.worst_read + t.worst_write;
        touched += t.read + t.write;
    }
    const double fragments = result.counts.input > 0 ? static_cast<double>(result.counts.input)
                                                     : std::numeric_limits<double>::quiet_NaN();
    return {seed,
            result.error->rmse8,
            result.error->rmse8_covered,
            result.error->mean_signed8,
            static_cast<double>(worst) / fragments,
            static_cast<double>(touched) / fragments};
}

void run_all(Convergence& convergence) {
    struct Job {
        const ConvergenceOfTechnique* technique;
        const ConvergenceAtValue* at;
        ConvergenceRun* run;
    };
    const ConvergenceOptions& options = convergence.options;
    std::vector<Job> queue;
    for (ConvergenceOfTechnique& technique : convergence.techniques)
        for (ConvergenceAtValue& at : technique.values) {
            at.runs.resize(technique.random ? static_cast<std::size_t>(options.seeds) : 1);
            for (std::size_t i = 0; i < at.runs.size(); ++i) {
                at.runs[i].seed = i + 1;
                queue.push_back({&technique, &at, &at.runs[i]});
            }
        }
    // The longest first: the last to end is then a short one.
    std::stable_sort(queue.begin(), queue.end(),
                     [](const Job& a, const Job& b) { return a.at->value > b.at->value; });
    const int cores = default_threads();
    const int jobs =
        std::clamp(cores / std::max(1, options.threads), 1, std::max(1, static_cast<int>(queue.size())));
    const int threads = options.threads > 0 ? options.threads : std::max(1, cores / jobs);
    Progress progress(queue.size());
    parallel_for(jobs, static_cast<int>(queue.size()), [&](int i) {
        const Job& job = queue[static_cast<std::size_t>(i)];
        const std::string technique = with_value(job.technique->technique, options.key, job.at->text);
        *job.run = one_run(options, technique, job.run->seed, threads);
        progress.finished(fmt::format("{} seed {}", technique, job.run->seed));
    });
}

void summarise(Convergence& convergence) {
    for (ConvergenceOfTechnique& technique : convergence.techniques) {
        std::vector<Replicates> errors;
        for (std::size_t v = 0; v < technique.values.size(); ++v) {
            ConvergenceAtValue& at = technique.values[v];
            errors.push_back({at.value, at.all(&ConvergenceRun::rmse8)});
            if (&technique != convergence.techniques.data())
                at.ratio = paired_ratio(errors.back().y,
                                        convergence.techniques[0].values[v].all(&ConvergenceRun::rmse8));
        }
        technique.fit = fit_power_law(convergence.options.key, errors);
    }
}

}  // namespace

std::vector<double> ConvergenceAtValue::all(double ConvergenceRun::*member) const {
    std::vector<double> numbers;
    for (const ConvergenceRun& run : runs) numbers.push_back(run.*member);
    return numbers;
}

void check_convergence(const ConvergenceOptions& options) {
    const TraceReader trace(options.trace);
    prepared(options, trace);
}

Convergence run_convergence(const ConvergenceOptions& options) {
    TraceReader trace(options.trace);
    Convergence convergence = prepared(options, trace);
    // Before the runs, so that they find it in the cache instead of all computing it.
    cached_reference_image(trace, default_threads());
    run_all(convergence);
    summarise(convergence);
    return convergence;
}

}  // namespace ropsim
