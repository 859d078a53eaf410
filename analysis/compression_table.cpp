// A study of compression as aligned plain text.
#include "analysis/comparison_table.h"
#include "analysis/compression_output.h"
#include "analysis/text_table.h"

#include <algorithm>

#include <fmt/format.h>

namespace ropsim {
namespace {

using Row = std::vector<std::string>;

constexpr std::size_t kOff = 0;
constexpr std::size_t kLastOnChip = 3;  // setup whose codecs the one with states in memory has, too
constexpr std::size_t kStates = 4;

std::string megabytes(std::uint64_t bytes) {
    return format_measured(static_cast<double>(bytes) * 1e-6, 2, ",", "-");
}

std::string saved_text(const PinGroups& off, const PinGroups& on) {
    if (off.sum() == 0) return "-";
    return fmt::format("{}{:.1f}", on.sum() > off.sum() ? "loses " : "", 100 * saved_share(off, on));
}

std::string frame_table(const CompressionStudy& study, const CompressionScene& scene) {
    std::vector<Row> rows{{"whole frame", "off, MB", "bytes a fragment"}};
    for (std::size_t i = 1; i < study.setups.size(); ++i)
        rows[0].push_back(fmt::format("{}, saved %", study.setups[i].name()));
    for (const CompressionRun& run : scene.runs) {
        if (!run.failure.empty()) continue;
        const PinGroups off = run.pins(kOff);
        Row row{run.technique, megabytes(off.sum()),
                format_measured(static_cast<double>(off.sum()) / static_cast<double>(scene.fragments), 1, ",",
                                "-")};
        for (std::size_t i = 1; i < study.setups.size(); ++i) row.push_back(saved_text(off, run.pins(i)));
        rows.push_back(row);
    }
    return aligned_table(rows);
}

// A class' codec is shown once, of the last setup on chip that has it.
bool shown(const CompressionStudy& study, std::size_t setup, SurfaceClass surface_class) {
    const auto codec = [&](std::size_t i) {
        return study.setups[i].codecs[static_cast<std::size_t>(surface_class)];
    };
    for (std::size_t later = setup + 1; later <= kLastOnChip; ++later)
        if (codec(later) == codec(setup)) return false;
    return true;
}

struct Line {
    std::int64_t lost;  // bytes
    Row row;
};

Line line_of(const CompressionStudy& study, const CompressionRun& run, const StudiedSurface& surface,
             std::size_t setup) {
    const SurfaceOutcome& outcome = surface.outcomes[setup];
    const CompressionCounts& blocks = outcome.blocks;
    const PinGroups& off = surface.outcomes[kOff].pins;
    std::uint64_t written = blocks.raw + blocks.kept_raw;
    for (const std::uint64_t level : blocks.by_level) written += level;
    const auto percent = [&](std::uint64_t count) {
        return written == 0
                   ? std::string("-")
                   : fmt::format("{:.0f}", 100.0 * static_cast<double>(count) / static_cast<double>(written));
    };
    const double ratio = storage_ratio(blocks);
    Row row{run.technique, surface.name,
            surface.elements == 0   ? fmt::format("pool of {}", surface.element_bytes)
            : surface.elements == 1 ? fmt::format("{}", surface.element_bytes)
                                    : fmt::format("{} x {}", surface.elements, surface.element_bytes),
            fmt::format("{} {}", class_name(surface.surface_class),
                        study.setups[setup].codecs[static_cast<std::size_t>(surface.surface_class)]),
            ratio > 0 ? fmt::format("{:.2f}", ratio) : "-"};
    for (const std::uint64_t level : blocks.by_level) row.push_back(percent(level));
    row.insert(row.end(),
               {percent(blocks.raw), percent(blocks.kept_raw), percent(blocks.repacks), megabytes(off.fill),
                megabytes(outcome.pins.fill), megabytes(off.write), megabytes(outcome.pins.write),
                megabytes(outcome.pins.repack), saved_text(off, outcome.pins),
                setup == kLastOnChip ? megabytes(surface.outcomes[kStates].pins.metadata) : "",
                setup == kLastOnChip ? saved_text(off, surface.outcomes[kStates].pins) : ""});
    return {static_cast<std::int64_t>(outcome.pins.sum()) - static_cast<std::int64_t>(off.sum()), row};
}

std::string surface_table(const CompressionStudy& study, const CompressionScene& scene) {
    std::vector<Line> lines;
    for (const CompressionRun& run : scene.runs)
        for (const StudiedSurface& surface : run.surfaces)
            for (std::size_t setup = 1; setup <= kLastOnChip; ++setup)
                if (shown(study, setup, surface.surface_class))
                    lines.push_back(line_of(study, run, surface, setup));
    std::ranges::stable_sort(lines, std::ranges::greater(), &Line::lost);
    std::vector<Row> rows{{"technique", "surface", "bytes", "codec", "stored"}};
    for (const std::uint32_t level : study.machine.compression.levels)
        rows[0].push_back(fmt::format("% of {}", level));
    rows[0].insert(rows[0].end(), {"% raw", "% kept raw", "% repacked", "fill, MB", "on", "write, MB", "on",
                                   "repack, MB", "saved %", "states, MB", "saved %"});
    for (const Line& line : lines) rows.push_back(line.row);
    return aligned_table(rows);
}

}  // namespace

std::string compression_table(const CompressionStudy& study) {
    std::string text;
    for (const CompressionScene& scene : study.scenes) {
        text += fmt::format("{}{}: {}x{} pixels, {} fragments; lines of {} bytes, blocks of {}\n\n",
                            text.empty() ? "" : "\n", scene.name, scene.width, scene.height,
                            format_measured(static_cast<double>(scene.fragments), 0, ",", ""),
                            study.machine.cache.line_bytes, study.machine.compression.block_bytes);
        text += frame_table(study, scene) + "\n" + surface_table(study, scene);
        for (const CompressionRun& run : scene.runs)
            if (!run.failure.empty()) text += fmt::format("{}: {}\n", run.technique, run.failure);
    }
    return text;
}

}  // namespace ropsim
