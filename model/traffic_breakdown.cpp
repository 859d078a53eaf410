#include "model/traffic_breakdown.h"

#include "base/error.h"

#include <algorithm>

namespace ropsim {

namespace {

ReadWriteBytes sum_of(const std::vector<ReadWriteBytes>& parts) {
    ReadWriteBytes sum;
    for (const ReadWriteBytes& one : parts) {
        sum.read += one.read;
        sum.write += one.write;
    }
    return sum;
}

void expect_equal(const char* what, const ReadWriteBytes& parts, const ReadWriteBytes& all) {
    CHECK(parts.read == all.read && parts.write == all.write, "{}: {} and {} of {} and {}", what, parts.read,
          parts.write, all.read, all.write);
}

}  // namespace

TrafficBreakdown::TrafficBreakdown(const std::vector<std::string>& passes, std::size_t draws, int across,
                                   int down)
    : draws_(draws + 1),
      tiles_(static_cast<std::size_t>(across) * static_cast<std::size_t>(down)),
      across_(across),
      down_(down) {
    for (const std::string& name : passes) passes_.push_back({name, {}});
}

// A tile at a lower resolution covers scale x scale of the screen; what is left of an even share goes to its
// first.
void TrafficBreakdown::add_elsewhere(const ByteSource& source, std::uint32_t bytes, bool write) {
    const auto to = [&](ReadWriteBytes& sum, std::uint64_t part) { (write ? sum.write : sum.read) += part; };
    if (source.tile == ByteSource::kNoTile) return to(without_tile_, bytes);
    const int scale = source.scale;
    const int x = static_cast<int>(source.tile) % across_ * scale;
    const int y = static_cast<int>(source.tile) / across_ * scale;
    std::vector<std::size_t> covered;
    for (int v = y; v < std::min(y + scale, down_); ++v)
        for (int u = x; u < std::min(x + scale, across_); ++u)
            covered.push_back(static_cast<std::size_t>(v) * static_cast<std::size_t>(across_) +
                              static_cast<std::size_t>(u));
    CHECK(!covered.empty(), "tile {} at a {}th of the resolution", source.tile, scale);
    const std::uint64_t share = bytes / covered.size();
    for (const std::size_t tile : covered) to(tiles_[tile], share);
    to(tiles_[covered[0]], bytes - share * covered.size());
}

void TrafficBreakdown::check(const BytesByCause& miss_port) const {
    ReadWriteBytes all;
    for (const auto& causes : miss_port) {
        for (const CauseBytes& cause : causes) {
            all.read += cause.read;
            all.write += cause.write;
        }
    }
    std::vector<ReadWriteBytes> passes;
    for (const OfPass& pass : passes_) passes.push_back(pass.bytes);
    expect_equal("passes", sum_of(passes), all);
    expect_equal("draws", sum_of(draws_), all);
    std::vector<ReadWriteBytes> tiles = tiles_;
    tiles.push_back(without_tile_);
    expect_equal("tiles", sum_of(tiles), all);
}

}  // namespace ropsim
