// One partition's share of the functional frame; private to Frame.
#pragma once

#include "model/frame.h"
#include "rop/operation_log.h"
#include "rop/pixel_store.h"

namespace ropsim {

// What an operation that gathers did at a pixel, at a quad's pixels and at a tile's quads.
struct Frame::GatheredPixel {
    bool inside = false;  // of the image
    std::uint8_t path = 0;
    std::array<std::uint32_t, 2> steps{};
    PixelAccess access{};
};
struct Frame::GatheredQuad {
    std::array<GatheredPixel, 4> pixels{};
    std::vector<GatherRead> reads;
};
struct Frame::GatheredTile {
    std::size_t tile = 0;
    std::array<GatheredQuad, 16> quads{};
};

struct Frame::Shard {
    Shard(const Frame& frame, std::uint64_t pool_nodes)
        : store(frame.operation_.declaration(), frame.trace_.header(), pool_nodes,
                frame.operation_.pixel_constant()),
          log(frame.operation_.declaration(), frame.quads_, frame.kept_values()),
          readout(frame.operation_.declaration(), false),
          collector(frame.map_, frame.config_) {}

    PixelStore store;
    OperationLog log;
    OperationLog readout;  // of a technique without resolve: reading the finished image is nobody's traffic
    LineCollector collector;
    std::vector<std::uint32_t> operated;  // fragments of the batch, by index
    std::vector<std::uint32_t> quads;     // this partition's quads of the batch, by number, in order
    std::vector<std::size_t> tiles;       // of the batch, in the initialise and resolve stages
    std::vector<std::size_t> tile_quads;  // first quad of each
    std::vector<GatheredTile> gathered;   // of the batch, where operations gather
};

}  // namespace ropsim
