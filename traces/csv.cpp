// Fragments as comma-separated text, in arrival order: import to a trace, export from one.
#include "traces/csv.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "traces/csv_reader.h"
#include "traces/trace.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <memory>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {

namespace {

// The header needs what only the whole file tells: the bounding box and the number of draws.
TraceHeader survey(const std::string& path) {
    CsvReader reader(path);
    const CsvPreamble& preamble = reader.preamble();
    TraceHeader header;
    int draws = 1;
    Fragment fragment{};
    while (reader.next(fragment)) {
        header.width = std::max(header.width, fragment.x + 1);
        header.height = std::max(header.height, fragment.y + 1);
        draws = std::max(draws, fragment.draw + 1);
    }
    if (preamble.width) header.width = *preamble.width;
    if (preamble.height) header.height = *preamble.height;
    if (header.width == 0)
        throw UserError(path,
                        "holds no fragments and no size; add a line '# size WIDTHxHEIGHT' before the header");
    header.samples = preamble.samples;
    header.background = preamble.background;
    header.scene = "imported from CSV";
    if (preamble.camera) {
        Camera camera;
        camera.near_plane = preamble.camera->near_plane;
        camera.far_plane = preamble.camera->far_plane;
        camera.fovy_degrees = preamble.camera->fovy_degrees;
        // In double, so that the float result is the same on every machine.
        camera.projection = glm::mat4(glm::perspective(glm::radians(double{camera.fovy_degrees}),
                                                       static_cast<double>(header.width) / header.height,
                                                       double{camera.near_plane}, double{camera.far_plane}));
        header.camera = camera;
    }
    for (int i = 0; i < draws; ++i) {
        Draw draw;
        draw.name = fmt::format("draw {}", i);
        draw.object_id = static_cast<std::uint32_t>(i);
        header.draws.push_back(std::move(draw));
    }
    return header;
}

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

void import_csv(const std::string& csv_path, const std::string& trace_path) {
    TraceWriter writer(trace_path, survey(csv_path));
    CsvReader reader(csv_path);
    Fragment fragment{};
    while (reader.next(fragment)) writer.append(&fragment, 1);
    writer.finish();
}

void export_csv(const std::string& trace_path, const std::string& csv_path) {
    TraceReader reader(trace_path);
    const TraceHeader& header = reader.header();
    AtomicFile target(csv_path);
    const std::unique_ptr<std::FILE, CloseFile> out(std::fopen(target.temporary_path().c_str(), "wb"));
    fmt::memory_buffer text;
    const auto flush = [&] {
        if (!out || std::fwrite(text.data(), 1, text.size(), out.get()) != text.size() ||
            std::fflush(out.get()) != 0)
            throw UserError(csv_path, fmt::format("cannot write ({}); check the disk", std::strerror(errno)));
        text.clear();
    };
    const auto put = std::back_inserter(text);
    fmt::format_to(put, "# size {}x{}\n# background {} {} {}\n# samples {}\n", header.width, header.height,
                   header.background.r, header.background.g, header.background.b, header.samples);
    if (header.camera)
        fmt::format_to(put, "# camera {} {} {}\n", header.camera->near_plane, header.camera->far_plane,
                       header.camera->fovy_degrees);
    fmt::format_to(put, "x,y,z,R,G,B,a,coverage,draw,primitive\n");
    std::vector<Fragment> chunk;
    while (reader.next(chunk)) {
        for (const Fragment& f : chunk) {
            // fmt writes the shortest text that reads back to the same float.
            fmt::format_to(put, "{},{},{},{},{},{},{},{},{},{}\n", f.x, f.y, f.z, f.r, f.g, f.b, f.a,
                           f.coverage, f.draw, f.primitive);
            if (text.size() > (1u << 20)) flush();
        }
    }
    flush();
    target.commit();
}

}  // namespace ropsim
