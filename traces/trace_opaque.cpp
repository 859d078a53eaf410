// The opaque layer as fragments: tile by tile and quad by quad, as a rasteriser would send a full screen.
#include "traces/trace_opaque.h"

#include "base/error.h"
#include "traces/depth_test.h"
#include "traces/half_float.h"
#include "traces/trace.h"
#include "traces/value_ranges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace ropsim {
namespace {

constexpr std::size_t kPiece = 1u << 16;

// One sample of the opaque layer.
struct OpaqueSample {
    std::array<float, 3> rgb{};
    float depth = 0;

    bool drawn() const { return std::isfinite(depth); }
    bool operator==(const OpaqueSample&) const = default;
};

OpaqueSample sample_of(const OpaqueLayer& layer, std::size_t element) {
    return {{layer.rgb[3 * element], layer.rgb[3 * element + 1], layer.rgb[3 * element + 2]},
            layer.depth[element]};
}

std::size_t pixel_of(const TraceHeader& header, int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(header.width) + static_cast<std::size_t>(x);
}

// The header of the new trace: what was behind the opaque layer, and its draw.
TraceHeader converted_header(const TraceHeader& header, OpaqueConversion& done) {
    TraceHeader converted = header;
    OpaqueLayer& layer = *converted.opaque;
    const glm::vec3 background = header.background;
    for (std::size_t i = 0; i < layer.depth.size(); ++i) {
        float* rgb = &layer.rgb[3 * i];
        if (!std::isfinite(layer.depth[i])) {
            done.layer_left =
                done.layer_left || rgb[0] != background.r || rgb[1] != background.g || rgb[2] != background.b;
            continue;
        }
        for (std::size_t c = 0; c < 3; ++c)
            done.widened_colors = done.widened_colors || (header.color_storage == ColorStorage::kFloat16 &&
                                                          float_from_half(half_from_float(rgb[c])) != rgb[c]);
        rgb[0] = background.r;
        rgb[1] = background.g;
        rgb[2] = background.b;
        layer.depth[i] = std::numeric_limits<float>::infinity();
    }
    if (!done.layer_left) converted.opaque.reset();
    if (done.widened_colors) converted.color_storage = ColorStorage::kFloat32;
    Draw draw;
    draw.name = "opaque";
    for (const Draw& other : header.draws) draw.object_id = std::max(draw.object_id, other.object_id + 1);
    draw.depth_write = true;
    converted.draws.push_back(draw);
    return converted;
}

class Converter {
 public:
    Converter(const std::string& in, const std::string& out, OpaquePlace place)
        : reader_(in), header_(reader_.header()), place_(place), path_(out) {
        if (!header_.opaque || std::none_of(header_.opaque->depth.begin(), header_.opaque->depth.end(),
                                            [](float depth) { return std::isfinite(depth); }))
            throw UserError(in, "has nothing opaque that could become fragments; use the trace as it is");
        if (header_.draws.size() > std::numeric_limits<std::uint16_t>::max())
            throw UserError(in, "has as many draws as a trace can hold; cut some with 'trace cut --draws'");
    }

    OpaqueConversion run() {
        TraceWriter writer(path_, converted_header(header_, done_));
        if (place_ == OpaquePlace::kFirst) write_opaque(writer);
        write_others(writer);
        if (place_ == OpaquePlace::kLast) write_opaque(writer);
        writer.finish();
        return done_;
    }

 private:
    void flush(TraceWriter& writer, FragmentChunk& piece, std::size_t most) const {
        if (piece.size() < most || piece.empty()) return;
        if (header_.depth_slopes) piece.slopes.resize(piece.size());
        if (header_.materials) piece.materials.resize(piece.size());
        writer.append(piece);
        piece.clear();
    }

    void write_opaque(TraceWriter& writer) {
        FragmentChunk piece;
        for (int ty = 0; ty < header_.height; ty += kTileSize)
            for (int tx = 0; tx < header_.width; tx += kTileSize)
                for (int i = 0; i < kTilePixels; ++i) {
                    // Bits of i from the lowest: x and y in the quad, then the quad in its row and column.
                    const int x = tx + (i >> 2) % 4 * 2 + (i & 1);
                    const int y = ty + (i >> 4) * 2 + (i >> 1 & 1);
                    if (x >= header_.width || y >= header_.height) continue;
                    add_pixel(x, y, piece);
                    flush(writer, piece, kPiece);
                }
        flush(writer, piece, 1);
    }

    void add_pixel(int x, int y, FragmentChunk& piece) {
        const auto samples = static_cast<std::size_t>(header_.samples);
        const std::size_t first = pixel_of(header_, x, y) * samples;
        std::uint32_t left = (1u << header_.samples) - 1u;
        for (std::size_t m = 0; m < samples; ++m) {
            const OpaqueSample sample = sample_of(*header_.opaque, first + m);
            if ((left >> m & 1u) == 0 || !sample.drawn()) continue;
            std::uint32_t group = 0;
            for (std::size_t other = m; other < samples; ++other)
                if (sample_of(*header_.opaque, first + other) == sample) group |= 1u << other;
            left &= ~group;
            if (done_.fragments >= kBackFacing)
                throw UserError(reader_.path(),
                                "has too many opaque samples for one draw's primitives; cut "
                                "it with 'trace cut'");
            piece.fragments.push_back({sample.depth, sample.rgb[0], sample.rgb[1], sample.rgb[2], 1.0f,
                                       static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                                       static_cast<std::uint32_t>(done_.fragments),
                                       static_cast<std::uint16_t>(group),
                                       static_cast<std::uint16_t>(header_.draws.size())});
            ++done_.fragments;
        }
    }

    void write_others(TraceWriter& writer) {
        FragmentChunk chunk;
        FragmentChunk kept;
        while (reader_.next_raw(chunk)) {
            kept.clear();
            for (std::size_t i = 0; i < chunk.size(); ++i) {
                Fragment f = chunk.fragments[i];
                const DepthSlope slope = header_.depth_slopes ? chunk.slopes[i] : DepthSlope{};
                if (!keep(f, slope)) continue;
                kept.fragments.push_back(f);
                if (header_.depth_slopes) kept.slopes.push_back(slope);
                if (header_.materials) kept.materials.push_back(chunk.materials[i]);
            }
            writer.append(kept);
        }
    }

    // Takes away the samples that would come to lie in front of the opaque layer by arrival.
    bool keep(Fragment& f, const DepthSlope& slope) {
        Fragment tested = f;
        bring_into_range(tested);
        const auto positions = sample_positions(header_.samples);
        const auto samples = static_cast<std::size_t>(header_.samples);
        const std::size_t first = pixel_of(header_, f.x, f.y) * samples;
        std::uint32_t coverage = f.coverage & ((1u << header_.samples) - 1u);
        if (coverage == 0) return true;
        for (std::size_t m = 0; m < samples; ++m) {
            if ((coverage >> m & 1u) == 0) continue;
            const float opaque = header_.opaque->depth[first + m];
            const float z = samples == 1 ? tested.z : sample_depth(tested, slope, positions[m]);
            const bool tests = header_.draws[f.draw].depth_test;
            // Without the test, a fragment at the layer's depth is seen; it stays so behind it by arrival.
            if (!tests && (place_ == OpaquePlace::kFirst ? z >= opaque : z > opaque))
                throw UserError(reader_.path(),
                                fmt::format("draw {} ('{}') has no depth test and a fragment behind the "
                                            "opaque layer at pixel {},{}, which would be hidden; leave the "
                                            "draw out with 'trace cut --draws'",
                                            f.draw, header_.draws[f.draw].name, f.x, f.y));
            if (tests && place_ == OpaquePlace::kLast && z == opaque) coverage &= ~(1u << m);
        }
        f.coverage = static_cast<std::uint16_t>(coverage);
        if (coverage == 0) ++done_.ties_removed;
        return coverage != 0;
    }

    TraceReader reader_;
    const TraceHeader& header_;
    OpaquePlace place_;
    std::string path_;
    OpaqueConversion done_;
};

}  // namespace

OpaqueConversion convert_opaque(const std::string& trace_path, const std::string& out_path,
                                OpaquePlace place) {
    return Converter(trace_path, out_path, place).run();
}

}  // namespace ropsim
