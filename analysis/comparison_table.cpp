// Columns and their plain-text table.
#include "analysis/comparison_table.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Member pointers keep the list of columns short.
std::function<Measured(const RunRecord&)> scaled(Measured RunRecord::*member, double factor = 1.0) {
    return [=](const RunRecord& run) -> Measured {
        const Measured& value = run.*member;
        return value ? Measured(*value * factor) : Measured();
    };
}

std::function<Measured(const RunRecord&)> per_fragment(Measured RecordedTraffic::*read,
                                                       Measured RecordedTraffic::*write) {
    return [=](const RunRecord& run) -> Measured {
        const Measured bytes = sum_of(run.total.*read, run.total.*write);
        if (!bytes || !run.fragments || *run.fragments <= 0) return {};
        return *bytes / *run.fragments;
    };
}

Measured percent(const Measured& part, const Measured& rest) {
    if (!part || !rest || *part + *rest <= 0) return {};
    return 100.0 * *part / (*part + *rest);
}

// FLIP's unit on the page; plain text has no dash for it.
constexpr const char* kUnitInterval = "0\u20131";
constexpr std::string_view kGap = "  ";
constexpr std::string_view kGroupGap = "    ";

std::string padded(const std::string& text, std::size_t width, bool left) {
    const std::string space(width - std::min(width, text.size()), ' ');
    return left ? text + space : space + text;
}

// The groups' names over their columns, whose first one is widened where a name needs more room.
std::string group_line(std::vector<std::size_t>& widths) {
    const auto& columns = comparison_columns();
    std::string line(widths[0], ' ');
    for (std::size_t first = 0; first < columns.size();) {
        std::size_t width = widths[first + 1], end = first + 1;
        for (; end < columns.size() && columns[end].group == columns[first].group; ++end)
            width += kGap.size() + widths[end + 1];
        const std::size_t needed = columns[first].group.size();
        if (needed > width) {
            widths[first + 1] += needed - width;
            width = needed;
        }
        line += first == 0 ? kGap : kGroupGap;
        line += padded(columns[first].group, width, true);
        first = end;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    return line + "\n";
}

}  // namespace

Measured sum_of(const Measured& read, const Measured& write) {
    if (!read && !write) return {};
    return read.value_or(0.0) + write.value_or(0.0);
}

const std::vector<ComparisonColumn>& comparison_columns() {
    static const std::vector<ComparisonColumn> columns{
        {"error", "RMSE", "/255", "root mean square error of linear values over all pixels", 3,
         scaled(&RunRecord::rmse8)},
        {"error", "covered RMSE", "/255", "the same over pixels with a transparent fragment", 3,
         scaled(&RunRecord::rmse8_covered)},
        {"error", "PSNR", "dB", "peak signal-to-noise ratio", 2, scaled(&RunRecord::psnr_db)},
        {"error", "FLIP", kUnitInterval, "mean visible difference", 4, scaled(&RunRecord::flip)},
        {"pixel state", "storage", "bit/px", "pixel state kept in memory", 0,
         scaled(&RunRecord::storage_bits_per_pixel)},
        {"traffic", "worst case", "B/frag", "bytes if every fragment took its costliest path", 2,
         per_fragment(&RecordedTraffic::worst_case_read, &RecordedTraffic::worst_case_write)},
        {"traffic", "touched", "B/frag", "bytes this trace asked for, before caches", 2,
         per_fragment(&RecordedTraffic::read, &RecordedTraffic::write)},
        {"traffic", "pins", "B/frag", "bytes on the DRAM pins, behind caches and compression", 2,
         per_fragment(&RecordedTraffic::pin_read, &RecordedTraffic::pin_write)},
        {"simulated", "cycles", "total", "cycles of the frame on the modelled hardware", 0,
         scaled(&RunRecord::cycles)},
        {"simulated", "time", "ms", "time of the frame on the modelled hardware", 3,
         scaled(&RunRecord::seconds, 1e3)},
        {"simulator", "speed", "Mfrag/s", "speed of the simulator itself", 2,
         scaled(&RunRecord::host_fragments_per_second, 1e-6)},
    };
    return columns;
}

const std::vector<ComparisonColumn>& memory_columns() {
    static const std::vector<ComparisonColumn> columns{
        {"ROP cache", "hits", "%", "ROP cache accesses that hit", 1,
         [](const RunRecord& run) { return percent(run.cache_hits, run.cache_misses); }},
        {"DRAM", "read", "MB", "bytes read on the bus", 2, scaled(&RunRecord::dram_read_bytes, 1e-6)},
        {"DRAM", "write", "MB", "bytes written on the bus", 2, scaled(&RunRecord::dram_write_bytes, 1e-6)},
        {"DRAM", "row hits", "%", "DRAM accesses to an open row", 1,
         [](const RunRecord& run) {
             return percent(run.dram_row_hits, sum_of(run.dram_row_misses, run.dram_row_conflicts));
         }},
        {"DRAM", "bus busy", "%", "utilisation of the data bus", 1,
         scaled(&RunRecord::dram_utilisation, 100)},
    };
    return columns;
}

std::string format_measured(const Measured& value, int decimals, const std::string& separator,
                            const std::string& absent) {
    if (!value || std::isnan(*value)) return absent;
    if (std::isinf(*value)) return "inf";
    std::string text = fmt::format("{:.{}f}", std::abs(*value), decimals);
    const std::size_t point = std::min(text.find('.'), text.size());
    for (std::size_t i = point; i > 3; i -= 3) text.insert(i - 3, separator);
    const bool zero = text.find_first_of("123456789") == std::string::npos;
    return *value < 0 && !zero ? "-" + text : text;
}

std::string comparison_table(const std::vector<RunRecord>& runs) {
    const auto& columns = comparison_columns();
    std::vector<std::vector<std::string>> rows{{"technique"}, {""}};
    for (const ComparisonColumn& column : columns) {
        rows[0].push_back(column.heading);
        rows[1].push_back(column.unit == kUnitInterval ? "0-1" : column.unit);
    }
    for (const RunRecord& run : runs) {
        rows.push_back({run.technique});
        if (!run.failure.empty()) continue;
        for (const ComparisonColumn& column : columns)
            rows.back().push_back(format_measured(column.value(run), column.decimals, ",", "-"));
    }
    std::vector<std::size_t> widths(columns.size() + 1, 0);
    for (const auto& row : rows)
        for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
    std::string text = group_line(widths);
    for (std::size_t r = 0; r < rows.size(); ++r) {
        std::string line;
        for (std::size_t c = 0; c < rows[r].size(); ++c) {
            if (c > 0) line += c > 1 && columns[c - 1].group != columns[c - 2].group ? kGroupGap : kGap;
            line += padded(rows[r][c], widths[c], c == 0);
        }
        if (r >= 2 && !runs[r - 2].failure.empty()) line += "  failed: " + runs[r - 2].failure;
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + "\n";
    }
    for (const RunRecord& run : runs)
        if (!run.sample.empty()) text += fmt::format("{}: {}\n", run.technique, run.sample);
    return text;
}

}  // namespace ropsim
