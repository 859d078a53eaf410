#include "model/tiled_bins.h"

#include <algorithm>
#include <bit>

namespace ropsim {

TileBins::TileBins(TraceReader& trace, const MachineConfig& config, const SurfaceMap& map)
    : line_bytes_(config.cache.line_bytes),
      entry_bytes_(config.tiled.entry_bytes),
      primitive_bytes_(config.tiled.primitive_bytes),
      tile_parts_(config.tiles.side / kTileSize),
      blocks_(config.partitions),
      kept_(config.partitions),
      writes_(config.partitions) {
    const TilePlan& plan = config.tiles;
    const auto tiles = static_cast<std::size_t>(plan.across) * static_cast<std::size_t>(plan.down);
    primitives_of_.resize(tiles);
    blocks_of_.resize(tiles);
    std::vector<std::uint8_t> partition(tiles);
    for (std::size_t tile = 0; tile < tiles; ++tile) {
        const auto wide = static_cast<std::size_t>(plan.across);
        small_tile_.push_back(
            static_cast<std::uint32_t>(tile / wide * static_cast<std::size_t>(tile_parts_) *
                                           static_cast<std::size_t>(plan.small_across) +
                                       tile % wide * static_cast<std::size_t>(tile_parts_)));
        partition[tile] = static_cast<std::uint8_t>(map.partition_of(small_tile_[tile]));
    }
    constexpr std::uint64_t kNone = ~std::uint64_t{0};
    std::vector<std::uint64_t> last_of_tile(tiles, kNone);
    std::uint64_t last = kNone;
    std::vector<std::uint32_t> last_tile(
        config.partitions);  // by partition: of the last primitive kept there
    const int shift = std::countr_zero(static_cast<unsigned>(plan.side));
    trace.select_tiles({});
    trace.rewind();
    FragmentChunk chunk;
    while (trace.next(chunk, kNoChannels)) {
        for (const Fragment& f : chunk.fragments) {
            const std::uint64_t key = std::uint64_t{f.draw} << 32 | primitive_number(f);
            const auto tile = static_cast<std::uint32_t>((f.y >> shift) * plan.across + (f.x >> shift));
            if (last_of_tile[tile] == key) continue;
            if (last != key) {
                add_primitive(tile, partition[tile]);
                last_tile[partition[tile]] = small_tile_[tile];
            }
            last_of_tile[tile] = last = key;
            add_entry(tile, partition[tile]);
        }
    }
    // What is not full at the end.
    const std::uint32_t block_entries = line_bytes_ / entry_bytes_;
    for (std::size_t tile = 0; tile < tiles; ++tile)
        if (const std::size_t rest = primitives_of_[tile].size() % block_entries; rest != 0)
            writes_[partition[tile]].push_back({small_tile_[tile], blocks_of_[tile].back(),
                                                static_cast<std::uint32_t>(rest) * entry_bytes_, false});
    for (std::size_t p = 0; p < kept_.size(); ++p) {
        const std::uint64_t bytes = std::uint64_t{kept_[p]} * primitive_bytes_;
        if (bytes % line_bytes_ != 0)
            writes_[p].push_back({last_tile[p], static_cast<std::uint32_t>(bytes / line_bytes_),
                                  static_cast<std::uint32_t>(bytes % line_bytes_), true});
    }
}

void TileBins::add_entry(std::uint32_t tile, int partition) {
    const auto p = static_cast<std::size_t>(partition);
    const std::uint32_t block_entries = line_bytes_ / entry_bytes_;
    ++entries_;
    std::vector<std::uint32_t>& list = primitives_of_[tile];
    if (list.size() % block_entries == 0) blocks_of_[tile].push_back(blocks_[p]++);
    list.push_back(static_cast<std::uint32_t>(owner_.size() - 1));
    if (list.size() % block_entries == 0)
        writes_[p].push_back(
            {small_tile_[tile], blocks_of_[tile].back(), block_entries * entry_bytes_, false});
}

void TileBins::add_primitive(std::uint32_t tile, int partition) {
    const auto p = static_cast<std::size_t>(partition);
    owner_.push_back(static_cast<std::uint8_t>(partition));
    place_.push_back(kept_[p]);
    const std::uint64_t begin = std::uint64_t{kept_[p]++} * primitive_bytes_;
    const std::uint64_t end = begin + primitive_bytes_;
    for (std::uint64_t line = begin / line_bytes_; line < end / line_bytes_; ++line)
        writes_[p].push_back({small_tile_[tile], static_cast<std::uint32_t>(line), line_bytes_, true});
}

std::uint64_t TileBins::largest_share() const {
    std::uint64_t most = 0;
    for (std::size_t p = 0; p < blocks_.size(); ++p) {
        const std::uint64_t vertices = std::uint64_t{kept_[p]} * primitive_bytes_;
        most = std::max(most, (blocks_[p] + (vertices + line_bytes_ - 1) / line_bytes_) * line_bytes_);
    }
    return most;
}

std::uint64_t TileBins::written_bytes() const {
    return entries_ * entry_bytes_ + primitives() * primitive_bytes_;
}

std::uint64_t TileBins::read_bytes(std::uint32_t tile) const {
    return tile_entries(tile) * (entry_bytes_ + primitive_bytes_);
}

void TileBins::append_write(int partition, std::size_t number, const SurfaceMap& map,
                            LineCollector& collector, QuadBatch& batch) const {
    const Write& write = writes_[static_cast<std::size_t>(partition)][number];
    QuadOperation q;
    q.partition = static_cast<std::uint8_t>(partition);
    q.kind = QuadKind::kCopy;
    q.pass = 0;
    q.quad_id = write.tile * 16;
    q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
    collector.begin(batch, partition, true);
    const std::uint64_t base =
        write.vertices ? vertices_address(partition, map) : map.first_address(map.bins());
    collector.write(map.bins(), base + std::uint64_t{write.line} * line_bytes_, write.bytes, nullptr);
    q.line_count = collector.count();
    batch.quads.push_back(q);
}

void TileBins::append_reads(std::uint32_t tile, std::uint8_t pass, const SurfaceMap& map,
                            LineCollector& collector, QuadBatch& batch) const {
    const std::vector<std::uint32_t>& list = primitives_of_[tile];
    const std::uint32_t block_entries = line_bytes_ / entry_bytes_;
    const int home = map.partition_of(small_tile_[tile]);
    for (std::size_t block = 0; block < blocks_of_[tile].size(); ++block) {
        const std::size_t first = block * block_entries;
        const std::size_t last = std::min<std::size_t>(first + block_entries, list.size());
        for (int turn = 1; turn <= map.partitions(); ++turn) {  // the tile's own partition comes last
            const int partition = (home + turn) % map.partitions();
            QuadOperation q;
            q.partition = static_cast<std::uint8_t>(partition);
            q.kind = QuadKind::kCopy;
            q.pass = pass;
            q.quad_id = small_tile_[tile] * 16;
            q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
            collector.begin(batch, partition, true);
            if (partition == home)
                collector.read(
                    map.bins(),
                    map.first_address(map.bins()) + std::uint64_t{blocks_of_[tile][block]} * line_bytes_,
                    static_cast<std::uint32_t>(last - first) * entry_bytes_);
            for (std::size_t i = first; i < last; ++i)
                if (owner_[list[i]] == partition)
                    collector.read(
                        map.bins(),
                        vertices_address(partition, map) + std::uint64_t{place_[list[i]]} * primitive_bytes_,
                        primitive_bytes_);
            q.line_count = collector.count();
            if (q.line_count > 0) batch.quads.push_back(q);
        }
    }
}

}  // namespace ropsim
