// How fragments stand in our own deep OpenEXR files: channel names, types, and the record behind them.
#include "traces/interchange/deep_exr_records.h"

#include "traces/half_float.h"

#include <cstring>

#include <fmt/format.h>

namespace ropsim {

static_assert(sizeof(Material) == 8 * sizeof(float), "a material is copied as eight numbers");

std::vector<DeepChannel> fragment_channels(const TraceHeader& header) {
    std::vector<DeepChannel> channels{{"Z", Imf::FLOAT, offsetof(DeepRecord, z)},
                                      {"A", Imf::FLOAT, offsetof(DeepRecord, a)},
                                      {"order", Imf::UINT, offsetof(DeepRecord, order)},
                                      {"coverage", Imf::UINT, offsetof(DeepRecord, coverage)},
                                      {"draw", Imf::UINT, offsetof(DeepRecord, draw)},
                                      {"primitive", Imf::UINT, offsetof(DeepRecord, primitive)}};
    const bool halves = header.color_storage == ColorStorage::kFloat16;
    const auto add_colors = [&](std::initializer_list<const char*> names, std::size_t floats_at,
                                std::size_t halves_at) {
        std::size_t i = 0;
        for (const char* name : names) {
            channels.push_back(
                {name, halves ? Imf::HALF : Imf::FLOAT,
                 halves ? halves_at + i * sizeof(std::uint16_t) : floats_at + i * sizeof(float)});
            ++i;
        }
    };
    add_colors({"R", "G", "B"}, offsetof(DeepRecord, color), offsetof(DeepRecord, half_color));
    if (header.depth_slopes) {
        channels.push_back({"slope.dx", Imf::FLOAT, offsetof(DeepRecord, slope)});
        channels.push_back({"slope.dy", Imf::FLOAT, offsetof(DeepRecord, slope) + sizeof(float)});
    }
    if (header.materials)
        add_colors(
            {"transmission.R", "transmission.G", "transmission.B", "collimation", "eta", "N.X", "N.Y", "N.Z"},
            offsetof(DeepRecord, material), offsetof(DeepRecord, half_material));
    return channels;
}

DeepRecord to_record(const TraceHeader& header, const FragmentChunk& chunk, std::size_t i,
                     std::uint32_t order) {
    const Fragment& f = chunk.fragments[i];
    DeepRecord record{};
    record.z = f.z;
    record.a = f.a;
    record.color[0] = f.r;
    record.color[1] = f.g;
    record.color[2] = f.b;
    record.order = order;
    record.coverage = f.coverage;
    record.draw = f.draw;
    record.primitive = f.primitive;
    if (header.depth_slopes) record.slope = chunk.slopes[i];
    if (header.materials) std::memcpy(record.material, &chunk.materials[i], sizeof(Material));
    if (header.color_storage == ColorStorage::kFloat16) {
        for (std::size_t c = 0; c < 3; ++c) record.half_color[c] = half_from_float(record.color[c]);
        for (std::size_t c = 0; c < 8; ++c) record.half_material[c] = half_from_float(record.material[c]);
    }
    return record;
}

void from_record(const TraceHeader& header, const DeepRecord& record, int x, int y, FragmentChunk& chunk,
                 std::size_t i) {
    DeepRecord r = record;
    if (header.color_storage == ColorStorage::kFloat16) {
        for (std::size_t c = 0; c < 3; ++c) r.color[c] = float_from_half(r.half_color[c]);
        for (std::size_t c = 0; c < 8; ++c) r.material[c] = float_from_half(r.half_material[c]);
    }
    chunk.fragments[i] = {r.z,
                          r.color[0],
                          r.color[1],
                          r.color[2],
                          r.a,
                          static_cast<std::uint16_t>(x),
                          static_cast<std::uint16_t>(y),
                          r.primitive,
                          static_cast<std::uint16_t>(r.coverage),
                          static_cast<std::uint16_t>(r.draw)};
    if (header.depth_slopes) chunk.slopes[i] = r.slope;
    if (header.materials) std::memcpy(&chunk.materials[i], r.material, sizeof(Material));
}

std::vector<std::string> opaque_channels(int samples) {
    std::vector<std::string> names;
    for (int m = 0; m < samples; ++m)
        for (const char* name : {"R", "G", "B", "Z"})
            names.push_back(samples == 1 ? name : fmt::format("sample{}.{}", m, name));
    return names;
}

}  // namespace ropsim
