// A sweep as rows of text.
#include "analysis/comparison_table.h"
#include "analysis/sweep.h"
#include "analysis/text_table.h"

#include <algorithm>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct Column {
    const char* name;     // in the CSV
    const char* heading;  // in the table; nullptr: not there
    int decimals;
    Measured (*value)(const RunRecord&);
};

constexpr Column kColumns[] = {
    {"cycles", "cycles", 0, [](const RunRecord& r) { return r.cycles; }},
    {"seconds", "ms", 3, [](const RunRecord& r) { return r.seconds; }},
    {"pin_bytes", "pins MB", 2,
     [](const RunRecord& r) { return sum_of(r.total.pin_read, r.total.pin_write); }},
    {"pin_read_bytes", nullptr, 0, [](const RunRecord& r) { return r.total.pin_read; }},
    {"pin_write_bytes", nullptr, 0, [](const RunRecord& r) { return r.total.pin_write; }},
    {"touched_bytes", "touched MB", 2,
     [](const RunRecord& r) { return sum_of(r.total.read, r.total.write); }},
    {"touched_read_bytes", nullptr, 0, [](const RunRecord& r) { return r.total.read; }},
    {"touched_write_bytes", nullptr, 0, [](const RunRecord& r) { return r.total.write; }},
    {"storage_bits_per_pixel", "storage bit/px", 0,
     [](const RunRecord& r) { return r.storage_bits_per_pixel; }},
    {"bits_per_pixel_write", "written bit/px", 1, [](const RunRecord& r) { return r.bits_per_pixel_write; }},
    {"rmse8", "RMSE /255", 3, [](const RunRecord& r) { return r.rmse8; }},
    {"rmse8_covered", nullptr, 0, [](const RunRecord& r) { return r.rmse8_covered; }},
    {"dram_utilisation", "DRAM data %", 1, [](const RunRecord& r) { return r.dram_utilisation; }},
    {"host_seconds", "host s", 2, [](const RunRecord& r) { return r.host_seconds; }},
};

// The table's units are larger.
double scale_of(const Column& column) {
    const std::string_view heading = column.heading;
    if (heading.ends_with("MB")) return 1e-6;
    if (heading == "ms") return 1e3;
    if (heading.ends_with('%')) return 100;
    return 1;
}

}  // namespace

std::string sweep_csv(const Sweep& sweep) {
    std::string text;
    for (const SweepAxis& axis : sweep.axes) text += csv_field(axis.name) + ",";
    for (const Column& column : kColumns) text += std::string(column.name) + ",";
    text += "bottleneck,failure,directory\n";
    for (const SweepPoint& point : sweep.points) {
        for (const std::string& value : point.values) text += csv_field(value) + ",";
        for (const Column& column : kColumns) {
            const Measured value = column.value(point.run);
            text += (value && point.run.failure.empty() ? fmt::format("{}", *value) : "") + ",";
        }
        text += fmt::format("{},{},{}\n", csv_field(point.run.bottleneck), csv_field(point.run.failure),
                            csv_field(point.run.directory));
    }
    return text;
}

std::string sweep_table(const Sweep& sweep) {
    std::vector<const Column*> columns;
    for (const Column& column : kColumns)
        if (column.heading != nullptr && std::ranges::any_of(sweep.points, [&](const SweepPoint& p) {
                return column.value(p.run).has_value();
            }))
            columns.push_back(&column);
    std::vector<std::vector<std::string>> rows(1);
    for (const SweepAxis& axis : sweep.axes)
        if (axis.values.size() > 1) rows[0].push_back(axis.name);
    if (rows[0].empty()) rows[0].push_back(sweep.axes[1].name);
    for (const Column* column : columns) rows[0].emplace_back(column->heading);
    for (const SweepPoint& point : sweep.points) {
        std::vector<std::string> row;
        for (std::size_t a = 0; a < sweep.axes.size(); ++a)
            if (sweep.axes[a].values.size() > 1) row.push_back(point.values[a]);
        if (row.empty()) row.push_back(point.values[1]);
        if (!point.run.failure.empty()) {
            std::string name = row[0];
            for (std::size_t i = 1; i < row.size(); ++i) name += "  " + row[i];
            rows.push_back({name + "  " + point.run.failure});
            continue;
        }
        for (const Column* column : columns) {
            Measured value = column->value(point.run);
            if (value) *value *= scale_of(*column);
            row.push_back(format_measured(value, column->decimals, ",", "-"));
        }
        rows.push_back(row);
    }
    return aligned_table(rows);
}

}  // namespace ropsim
