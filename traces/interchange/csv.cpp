// Fragments as comma-separated text: import to a trace.
#include "traces/interchange/csv.h"

#include "base/error.h"
#include "traces/interchange/csv_reader.h"
#include "traces/trace.h"

#include <algorithm>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {

namespace {

constexpr std::size_t kPiece = 1u << 14;

// What a file's fragments tell of the header: the bounding box and the number of draws.
struct Extent {
    int width = 0, height = 0, draws = 1;
};

Extent survey(const std::string& path) {
    CsvReader reader(path);
    const CsvPreamble& preamble = reader.preamble();
    Extent extent;
    if (preamble.width && preamble.draws) return {*preamble.width, *preamble.height, *preamble.draws};
    CsvRow row;
    while (reader.next(row)) {
        extent.width = std::max(extent.width, row.fragment.x + 1);
        extent.height = std::max(extent.height, row.fragment.y + 1);
        extent.draws = std::max(extent.draws, row.fragment.draw + 1);
    }
    if (preamble.width) extent.width = *preamble.width;
    if (preamble.height) extent.height = *preamble.height;
    if (preamble.draws) extent.draws = *preamble.draws;
    if (extent.width == 0)
        throw UserError(path,
                        "holds no fragments and no size; add a line '# size WIDTHxHEIGHT' before the header");
    return extent;
}

Camera camera_of(const CsvPreamble::Lens& lens, const Extent& extent) {
    Camera camera;
    camera.near_plane = lens.near_plane;
    camera.far_plane = lens.far_plane;
    camera.fovy_degrees = lens.fovy_degrees;
    // In double, so that the float result is the same on every machine.
    camera.projection = glm::mat4(glm::perspective(glm::radians(double{camera.fovy_degrees}),
                                                   static_cast<double>(extent.width) / extent.height,
                                                   double{camera.near_plane}, double{camera.far_plane}));
    return camera;
}

TraceHeader header_of(const CsvReader& reader, const Extent& extent) {
    const CsvPreamble& preamble = reader.preamble();
    TraceHeader header;
    header.width = extent.width;
    header.height = extent.height;
    header.samples = preamble.samples;
    header.background = preamble.background;
    header.color_storage = preamble.color_storage;
    header.non_finite = preamble.non_finite;
    header.depth_slopes = reader.has_slopes();
    header.materials = reader.has_materials();
    header.scene = "imported from CSV";
    if (preamble.camera) header.camera = camera_of(*preamble.camera, extent);
    for (int i = 0; i < extent.draws; ++i) {
        Draw draw;
        draw.name = fmt::format("draw {}", i);
        draw.object_id = static_cast<std::uint32_t>(i);
        header.draws.push_back(std::move(draw));
    }
    return header;
}

}  // namespace

std::vector<std::string> import_csv(const std::string& csv_path, const std::string& trace_path) {
    const Extent extent = survey(csv_path);
    CsvReader reader(csv_path);
    const TraceHeader header = header_of(reader, extent);
    TraceWriter writer(trace_path, header);
    CsvRow row;
    FragmentChunk piece;
    std::uint64_t fragments = 0;
    while (reader.next(row)) {
        piece.fragments.push_back(row.fragment);
        if (header.depth_slopes) piece.slopes.push_back(row.slope);
        if (header.materials) piece.materials.push_back(row.material);
        ++fragments;
        if (piece.size() < kPiece) continue;
        writer.append(piece);
        piece.clear();
    }
    writer.append(piece);
    writer.finish();
    const std::optional<std::uint64_t> expected = reader.preamble().fragments;
    if (!expected || *expected == fragments) return {};
    return {
        fmt::format("holds {} fragments where its comment '# fragments {}' expects others; was it cut short?",
                    fragments, *expected)};
}

}  // namespace ropsim
