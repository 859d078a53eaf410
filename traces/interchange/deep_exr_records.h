// How fragments stand in our own deep OpenEXR files: channel names, types, and the record behind them.
#pragma once

#include "traces/interchange/deep_exr_row.h"
#include "traces/trace.h"

#include <cstdint>
#include <vector>

namespace ropsim {

inline constexpr const char* kDeepHeaderAttribute = "ropsim.header";  // the header section of a trace file
inline constexpr const char* kDeepHashAttribute = "ropsim.hash";
inline constexpr const char* kFragmentPart = "fragments";
inline constexpr const char* kOpaquePart = "opaque";

// A fragment with its channels. Halves have places of their own, because OpenEXR writes what it finds.
struct DeepRecord {
    float z, a;
    float color[3];
    std::uint16_t half_color[3];
    std::uint32_t order, coverage, draw, primitive;
    DepthSlope slope;
    float material[8];  // as in Material, one after the other
    std::uint16_t half_material[8];
};

// The channels of a trace with this header.
std::vector<DeepChannel> fragment_channels(const TraceHeader& header);

// The record of element i of a chunk, which arrived as number `order`.
DeepRecord to_record(const TraceHeader& header, const FragmentChunk& chunk, std::size_t i,
                     std::uint32_t order);
// The inverse: into element i of a chunk that has room.
void from_record(const TraceHeader& header, const DeepRecord& record, int x, int y, FragmentChunk& chunk,
                 std::size_t i);

// Channel names of the opaque layer: R, G, B, Z of its only sample, sample0.R, ... where there are several.
std::vector<std::string> opaque_channels(int samples);

}  // namespace ropsim
