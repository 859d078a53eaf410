// Baselines as files, and the verdicts.
#include "analysis/bench/against.h"

#include "analysis/text_table.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/version.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kKind = "ropsim bench baseline";

void put(std::map<std::string, double>& values, const std::string& name, const Measured& value) {
    if (value) values[name] = *value;
}

// A sample is another one in every repeat; all else repeats itself.
BaselineEntry entry_of(const BenchCase& c) {
    BaselineEntry entry{c.id(), c.trace_hash, {}, {}};
    for (std::size_t i = 0; i < c.repeats.size(); ++i) {
        const BenchRepeat& repeat = c.repeats[i];
        entry.speed.push_back(repeat.processor_seconds / repeat.calibration_seconds);
        if (i > 0 && !c.sampled) continue;
        const std::string sample = c.sampled ? fmt::format(" of sample {}", i) : "";
        put(entry.values, "cycles" + sample, repeat.cycles);
        put(entry.values, "pin bytes" + sample, repeat.pin_bytes);
        if (!c.sampled) put(entry.values, "touched bytes", repeat.touched_bytes);
    }
    return entry;
}

BaselineEntry entry_of(const TradeoffTechnique& technique, const TradeoffScene& scene,
                       const TradeoffPoint& point) {
    BaselineEntry entry{fmt::format("techniques {} {}", scene.name, technique.technique), scene.hash, {}, {}};
    put(entry.values, "frame ms", point.frame_ms);
    put(entry.values, "pin bytes a fragment", point.pins);
    put(entry.values, "touched bytes a fragment", point.touched);
    put(entry.values, "rmse8", point.rmse8);
    return entry;
}

// Values that differ, or that only one of them has. They are written with all their digits.
std::string changes(const std::map<std::string, double>& then, const std::map<std::string, double>& now) {
    std::string text;
    const auto shown = [](const std::map<std::string, double>& values, const std::string& name) {
        const auto found = values.find(name);
        return found == values.end() ? std::string("none") : fmt::format("{:.10g}", found->second);
    };
    std::map<std::string, double> either = now;
    either.insert(then.begin(), then.end());
    for (const auto& [name, value] : either) {
        const std::string before = shown(then, name);
        const std::string after = shown(now, name);
        if (then.contains(name) && now.contains(name) && then.at(name) == now.at(name)) continue;
        text += fmt::format("{}{} {} -> {}", text.empty() ? "" : ", ", name, before, after);
    }
    return text;
}

BaselineEntry read_entry(const Json& json) {
    BaselineEntry entry{json.at("id"), json.at("trace_hash"), json.at("speed"), {}};
    for (const auto& [name, value] : json.at("values").items()) entry.values[name] = value;
    for (const double speed : entry.speed)
        if (!(speed > 0)) throw Json::other_error::create(501, "a speed is not above 0", &json);
    return entry;
}

AgainstRow compare_entries(const BaselineEntry& then, const BaselineEntry& now,
                           const AgainstOptions& options) {
    AgainstRow row{now.id, SpeedVerdict::kSame, {}, {}};
    if (then.trace_hash != now.trace_hash) {
        row.verdict = SpeedVerdict::kOtherTrace;
        return row;
    }
    if (!then.speed.empty() && !now.speed.empty()) {
        row = compare_speeds(then.speed, now.speed, options);
        row.id = now.id;
    }
    row.changed = changes(then.values, now.values);
    if (!row.changed.empty()) row.verdict = SpeedVerdict::kChanged;
    return row;
}

std::vector<std::string> row_text(const AgainstRow& row) {
    if (!row.changed.empty()) return {row.id, name_of(row.verdict), "", "", row.changed};
    if (!row.ratio) return {row.id, name_of(row.verdict), "", "", ""};
    return {row.id, name_of(row.verdict), fmt::format("{:.3f}", row.ratio->estimate),
            fmt::format("{:.3f} to {:.3f}", row.ratio->low, row.ratio->high), ""};
}

}  // namespace

const char* name_of(SpeedVerdict verdict) {
    static constexpr const char* kNames[] = {"same",      "regressed", "improved",
                                             "undecided", "changed",   "other trace"};
    return kNames[static_cast<std::size_t>(verdict)];
}

Baseline baseline_of(const Bench& bench) {
    Baseline baseline{kVersion, bench.host.processor, {}};
    if (bench.techniques)
        for (const TradeoffTechnique& technique : bench.techniques->techniques)
            for (std::size_t s = 0; s < technique.at.size(); ++s)
                if (technique.at[s].failure.empty())
                    baseline.entries.push_back(
                        entry_of(technique, bench.techniques->scenes[s], technique.at[s]));
    for (const BenchCase& c : bench.cases)
        if (!c.repeats.empty()) baseline.entries.push_back(entry_of(c));
    return baseline;
}

std::string baseline_json(const Baseline& baseline) {
    // An entry a line: small, and its changes can be read.
    std::string text =
        fmt::format("{{\"kind\": {}, \"ropsim\": {}, \"processor\": {}, \"entries\": [\n", Json(kKind).dump(),
                    Json(baseline.version).dump(), Json(baseline.processor).dump());
    for (std::size_t i = 0; i < baseline.entries.size(); ++i) {
        const BaselineEntry& entry = baseline.entries[i];
        Json json = {{"id", entry.id}, {"trace_hash", entry.trace_hash}, {"speed", Json::array()}};
        for (const double speed : entry.speed)
            json["speed"].push_back(std::stod(fmt::format("{:.4g}", speed)));  // noise has no more digits
        json["values"] = entry.values;
        text += json.dump(-1, ' ', false, Json::error_handler_t::replace) +
                (i + 1 < baseline.entries.size() ? ",\n" : "\n");
    }
    return text + "]}\n";
}

Baseline read_baseline(const std::string& file) {
    const Json json = Json::parse(read_file(file), nullptr, /*allow_exceptions=*/false);
    const UserError none(file, "is not a baseline; give the baseline.json of an earlier `ropsim bench`");
    if (!json.is_object() || json.value("kind", "") != kKind) throw UserError(none);
    try {
        Baseline baseline{json.at("ropsim"), json.at("processor"), {}};
        for (const Json& entry : json.at("entries")) baseline.entries.push_back(read_entry(entry));
        return baseline;
    } catch (const Json::exception&) {
        throw UserError(none);
    }
}

AgainstRow compare_speeds(const std::vector<double>& then, const std::vector<double>& now,
                          const AgainstOptions& options) {
    std::vector<double> earlier;
    std::vector<double> later;
    for (const double value : then) earlier.push_back(std::log(value));
    for (const double value : now) later.push_back(std::log(value));
    AgainstRow row;
    row.ratio = shift_interval(earlier, later, options.confidence);
    if (!row.ratio) {
        row.verdict = SpeedVerdict::kUndecided;
        return row;
    }
    for (double* end : {&row.ratio->estimate, &row.ratio->low, &row.ratio->high}) *end = std::exp(*end);
    if (row.ratio->low > 1 + options.least_effect) row.verdict = SpeedVerdict::kRegressed;
    if (row.ratio->high < 1 / (1 + options.least_effect)) row.verdict = SpeedVerdict::kImproved;
    return row;
}

Against compare_baselines(const Baseline& then, const Baseline& now, const AgainstOptions& options) {
    Against against;
    against.options = options;
    against.other_processor = then.processor != now.processor;
    for (const BaselineEntry& entry : now.entries) {
        const auto before = std::ranges::find(then.entries, entry.id, &BaselineEntry::id);
        if (before == then.entries.end())
            ++against.only_now;
        else
            against.rows.push_back(compare_entries(*before, entry, options));
    }
    against.only_then = then.entries.size() - against.rows.size();
    return against;
}

std::size_t Against::count(SpeedVerdict verdict) const {
    return static_cast<std::size_t>(std::ranges::count(rows, verdict, &AgainstRow::verdict));
}

std::string against_table(const Against& against) {
    std::vector<std::vector<std::string>> rows{{"case", "verdict", "time, now/then", "interval", "values"}};
    for (const AgainstRow& row : against.rows)
        if (row.verdict != SpeedVerdict::kSame) rows.push_back(row_text(row));
    std::string text = rows.size() > 1 ? aligned_table(rows) : "";
    text += fmt::format("against {}:", against.file);
    for (const SpeedVerdict verdict :
         {SpeedVerdict::kSame, SpeedVerdict::kRegressed, SpeedVerdict::kImproved, SpeedVerdict::kUndecided,
          SpeedVerdict::kChanged, SpeedVerdict::kOtherTrace})
        text += fmt::format(" {} {},", against.count(verdict), name_of(verdict));
    text += fmt::format(
        " {} only there, {} only here; a regression is an interval of {:g}% confidence beyond {:g}%\n",
        against.only_then, against.only_now, 100 * against.options.confidence,
        100 * against.options.least_effect);
    if (against.other_processor)
        text += "the baseline is of another processor: speeds are shown, not judged\n";
    return text;
}

std::string against_failure(const Against& against) {
    const std::size_t slower = against.other_processor ? 0 : against.count(SpeedVerdict::kRegressed);
    const std::size_t changed = against.count(SpeedVerdict::kChanged);
    if (slower == 0 && changed == 0) return {};
    return fmt::format(
        "{} cases are slower and {} have other results than {}; see the table, and make a new baseline if "
        "that "
        "is "
        "meant",
        slower, changed, against.file);
}

}  // namespace ropsim
