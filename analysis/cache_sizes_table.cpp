// A study of cache sizes as aligned plain text.
#include "analysis/cache_sizes_output.h"
#include "analysis/comparison_table.h"
#include "analysis/text_table.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

using Row = std::vector<std::string>;

constexpr std::uint64_t kFirstOctave = 1024;  // bytes, of the second table
constexpr std::uint64_t kLastOctave = std::uint64_t{16} << 20;

std::string shown(double value) {
    return format_measured(value, 1, ",", "-");
}

std::string size_text(std::uint64_t bytes) {
    if (bytes >= (1u << 20)) return fmt::format("{:.4g} MiB", static_cast<double>(bytes) / (1 << 20));
    return fmt::format("{:.4g} KiB", static_cast<double>(bytes) / 1024);
}

std::string size_text(const std::optional<std::uint64_t>& bytes) {
    return bytes ? size_text(*bytes) : "-";
}

std::string bytes_table(const CacheSizes& study, const CacheSizesScene& scene) {
    std::vector<Row> rows{{"bytes a fragment", "worst case", "touched", "bursts"}};
    for (const int kibibytes : study.options.kibibytes) rows[0].push_back(fmt::format("{} KiB", kibibytes));
    rows[0].insert(rows[0].end(), {"endless", "within 5% of largest"});
    for (const CacheSizesRun& run : scene.runs) {
        if (!run.failure.empty()) continue;
        Row row{run.technique, shown(scene.per_fragment(run.worst_case)),
                shown(scene.per_fragment(run.touched)), shown(scene.per_fragment(run.uncached))};
        Row ideal{"  fully associative", "", "", ""};
        for (std::size_t i = 0; i < run.sweep.caches.size(); ++i) {
            row.push_back(shown(scene.per_fragment(run.pins(i))));
            ideal.push_back(shown(scene.per_fragment(run.ideal_of(run.sweep.caches[i].size_bytes))));
        }
        row.insert(row.end(), {"", size_text(run.near_largest())});
        ideal.insert(ideal.end(), {shown(scene.per_fragment(run.floor())), ""});
        rows.push_back(row);
        rows.push_back(ideal);
    }
    return aligned_table(rows);
}

std::string savings_table(const CacheSizesScene& scene) {
    std::vector<Row> rows{{"% saved by a doubling", fmt::format("to {}", size_text(kFirstOctave))}};
    for (std::uint64_t size = 2 * kFirstOctave; size <= kLastOctave; size *= 2)
        rows[0].push_back(size_text(size));
    rows[0].insert(rows[0].end(), {"half at", "5% above endless", "a tile", "a partition"});
    for (const CacheSizesRun& run : scene.runs) {
        if (!run.failure.empty()) continue;
        Row row{run.technique};
        double before = 0;
        for (std::uint64_t size = kFirstOctave; size <= kLastOctave; size *= 2) {
            const double saved = run.saved_share(size).value_or(0);
            row.push_back(fmt::format("{:.0f}", 100 * (saved - before)));
            before = saved;
        }
        row.insert(row.end(), {size_text(run.half_saved()), size_text(run.near_floor()),
                               size_text(run.tile_bytes), size_text(run.sweep.largest_footprint)});
        rows.push_back(row);
    }
    return aligned_table(rows);
}

}  // namespace

std::string cache_sizes_table(const CacheSizes& study) {
    std::string text;
    for (const CacheSizesScene& scene : study.scenes) {
        text += fmt::format("{}{}: {}x{} pixels, {} fragments; 10 bytes a fragment are {:.3f} GB a frame\n\n",
                            text.empty() ? "" : "\n", scene.name, scene.width, scene.height,
                            format_measured(static_cast<double>(scene.fragments), 0, ",", ""),
                            1e-8 * static_cast<double>(scene.fragments));
        text += bytes_table(study, scene) + "\n" + savings_table(scene);
        for (const CacheSizesRun& run : scene.runs)
            if (!run.failure.empty()) text += fmt::format("{}: {}\n", run.technique, run.failure);
    }
    return text;
}

}  // namespace ropsim
