// Columns and their plain-text table.
#include "analysis/comparison_table.h"

#include <algorithm>
#include <cmath>

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

std::function<Measured(const RunRecord&)> per_fragment(Measured SurfaceTraffic::*read, Measured SurfaceTraffic::*write) {
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

std::string padded(const std::string& text, std::size_t width, bool left) {
    const std::string space(width - std::min(width, text.size()), ' ');
    return left ? text + space : space + text;
}

}  // namespace

Measured sum_of(const Measured& read, const Measured& write) {
    if (!read && !write) return {};
    return read.value_or(0.0) + write.value_or(0.0);
}

const std::vector<Column>& comparison_columns() {
    static const std::vector<Column> kColumns{
        {"RMSE", "/255", "root mean square error of linear values over all pixels", 3, scaled(&RunRecord::rmse8)},
        {"covered", "/255", "the same over pixels with a transparent fragment", 3, scaled(&RunRecord::rmse8_covered)},
        {"PSNR", "dB", "peak signal-to-noise ratio", 2, scaled(&RunRecord::psnr_db)},
        {"FLIP", "0\u20131", "mean visible difference", 4, scaled(&RunRecord::flip)},
        {"storage", "bit/px", "pixel state kept in memory", 0, scaled(&RunRecord::storage_bits_per_pixel)},
        {"worst case", "B/frag", "bytes if every fragment took its costliest path", 2,
         per_fragment(&SurfaceTraffic::worst_case_read, &SurfaceTraffic::worst_case_write)},
        {"touched", "B/frag", "bytes this trace asked for, before caches", 2,
         per_fragment(&SurfaceTraffic::read, &SurfaceTraffic::write)},
        {"pins", "B/frag", "bytes on the DRAM pins, behind caches and compression", 2,
         per_fragment(&SurfaceTraffic::pin_read, &SurfaceTraffic::pin_write)},
        {"cycles", "ROP clock", "simulated cycles of the frame", 0, scaled(&RunRecord::cycles)},
        {"time", "ms", "simulated time of the frame", 3, scaled(&RunRecord::seconds, 1e3)},
        {"host", "Mfrag/s", "speed of the simulator itself", 2, scaled(&RunRecord::host_fragments_per_second, 1e-6)},
    };
    return kColumns;
}

const std::vector<Column>& memory_columns() {
    static const std::vector<Column> kColumns{
        {"cache hits", "%", "ROP cache accesses that hit", 1,
         [](const RunRecord& run) { return percent(run.cache_hits, run.cache_misses); }},
        {"DRAM read", "MB", "bytes read on the bus", 2, scaled(&RunRecord::dram_read_bytes, 1e-6)},
        {"DRAM write", "MB", "bytes written on the bus", 2, scaled(&RunRecord::dram_write_bytes, 1e-6)},
        {"row hits", "%", "DRAM accesses to an open row", 1,
         [](const RunRecord& run) { return percent(run.dram_row_hits, sum_of(run.dram_row_misses, run.dram_row_conflicts)); }},
        {"DRAM busy", "%", "utilisation of the data bus", 1, scaled(&RunRecord::dram_utilisation, 100)},
    };
    return kColumns;
}

std::string format_measured(const Measured& value, int decimals, const std::string& separator, const std::string& absent) {
    if (!value || std::isnan(*value)) return absent;
    if (std::isinf(*value)) return "inf";
    std::string text = fmt::format("{:.{}f}", std::abs(*value), decimals);
    const std::size_t point = std::min(text.find('.'), text.size());
    for (std::size_t i = point; i > 3; i -= 3) text.insert(i - 3, separator);
    const bool zero = text.find_first_of("123456789") == std::string::npos;
    return *value < 0 && !zero ? "-" + text : text;
}

std::string comparison_table(const std::vector<RunRecord>& runs) {
    std::vector<std::vector<std::string>> rows(2, {"technique"});
    rows[1][0] = "";
    for (const Column& column : comparison_columns()) {
        rows[0].push_back(column.heading);
        rows[1].push_back(column.unit == "0\u20131" ? "0-1" : column.unit);
    }
    for (const RunRecord& run : runs) {
        rows.push_back({run.technique});
        if (!run.failure.empty()) continue;
        for (const Column& column : comparison_columns())
            rows.back().push_back(format_measured(column.value(run), column.decimals, ",", "-"));
    }
    std::vector<std::size_t> widths(rows[0].size(), 0);
    for (const auto& row : rows)
        for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
    std::string text;
    for (std::size_t r = 0; r < rows.size(); ++r) {
        std::string line;
        for (std::size_t c = 0; c < rows[r].size(); ++c)
            line += (c == 0 ? "" : "  ") + padded(rows[r][c], widths[c], c == 0);
        if (r >= 2 && !runs[r - 2].failure.empty()) line += "  failed: " + runs[r - 2].failure;
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + "\n";
    }
    return text;
}

}  // namespace ropsim
