// Fragments as comma-separated text: export from a trace.
#include "base/atomic_file.h"
#include "base/error.h"
#include "traces/interchange/csv.h"
#include "traces/trace.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <memory>

#include <fmt/compile.h>
#include <fmt/format.h>

namespace ropsim {

namespace {

constexpr std::size_t kPiece = 1u << 20;

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

// The shortest text that reads back to the same float; a NaN that is not the usual one with its bits.
void put_real(fmt::memory_buffer& text, float value) {
    const auto put = std::back_inserter(text);
    const auto bits = std::bit_cast<std::uint32_t>(value);
    if (std::isnan(value) && (bits & 0x7FFFFFFFu) != 0x7FC00000u)
        fmt::format_to(put, "nan({:#010x})", bits);
    else
        fmt::format_to(put, FMT_COMPILE("{}"), value);
    text.push_back(',');
}

// Whether any fragment faces back; leaves the reader at the first fragment.
bool any_faces_back(TraceReader& reader) {
    FragmentChunk chunk;
    bool found = false;
    while (!found && reader.next(chunk, kNoChannels))
        found = std::any_of(chunk.fragments.begin(), chunk.fragments.end(), faces_back);
    reader.rewind();
    return found;
}

void put_preamble(fmt::memory_buffer& text, const TraceReader& reader, bool facing) {
    const TraceHeader& header = reader.header();
    const auto put = std::back_inserter(text);
    fmt::format_to(put, "# size {}x{}\n# background {} {} {}\n# samples {}\n", header.width, header.height,
                   header.background.r, header.background.g, header.background.b, header.samples);
    if (header.camera)
        fmt::format_to(put, "# camera {} {} {}\n", header.camera->near_plane, header.camera->far_plane,
                       header.camera->fovy_degrees);
    if (header.color_storage == ColorStorage::kFloat16) fmt::format_to(put, "# color_storage float16\n");
    if (header.non_finite) fmt::format_to(put, "# non_finite 1\n");
    fmt::format_to(put, "# draws {}\n# fragments {}\n", header.draws.size(), reader.fragment_count());
    fmt::format_to(put, "x,y,z,R,G,B,a,coverage,draw,primitive{}{}{}\n", facing ? ",facing" : "",
                   header.depth_slopes ? ",dzdx,dzdy" : "",
                   header.materials ? ",tr,tg,tb,collimation,eta,nx,ny,nz" : "");
}

void put_fragment(fmt::memory_buffer& text, const TraceHeader& header, bool facing,
                  const FragmentChunk& chunk, std::size_t i) {
    const Fragment& f = chunk.fragments[i];
    const auto put = std::back_inserter(text);
    fmt::format_to(put, FMT_COMPILE("{},{},"), f.x, f.y);
    for (const float value : {f.z, f.r, f.g, f.b, f.a}) put_real(text, value);
    fmt::format_to(put, FMT_COMPILE("{},{},{},"), f.coverage, f.draw, primitive_number(f));
    if (facing) fmt::format_to(put, FMT_COMPILE("{},"), faces_back(f) ? 1 : 0);
    if (header.depth_slopes)
        for (const float value : {chunk.slopes[i].dx, chunk.slopes[i].dy}) put_real(text, value);
    if (header.materials) {
        const Material& m = chunk.materials[i];
        for (const float value : {m.transmission[0], m.transmission[1], m.transmission[2], m.collimation,
                                  m.eta, m.normal[0], m.normal[1], m.normal[2]})
            put_real(text, value);
    }
    text[text.size() - 1] = '\n';  // instead of the last comma
}

}  // namespace

void export_csv(const std::string& trace_path, const std::string& csv_path) {
    TraceReader reader(trace_path);
    AtomicFile target(csv_path);
    const std::unique_ptr<std::FILE, CloseFile> out(std::fopen(target.temporary_path().c_str(), "wb"));
    fmt::memory_buffer text;
    const auto flush = [&] {
        if (!out || std::fwrite(text.data(), 1, text.size(), out.get()) != text.size() ||
            std::fflush(out.get()) != 0)
            throw UserError(csv_path, fmt::format("cannot write ({}); check the disk", std::strerror(errno)));
        text.clear();
    };
    const bool facing = any_faces_back(reader);
    put_preamble(text, reader, facing);
    FragmentChunk chunk;
    while (reader.next_raw(chunk)) {
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            put_fragment(text, reader.header(), facing, chunk, i);
            if (text.size() > kPiece) flush();
        }
    }
    flush();
    target.commit();
}

}  // namespace ropsim
