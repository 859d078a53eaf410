// A frame that is run one group of tiles after the other, for the tiled engine.
#include "model/compressed_surfaces.h"
#include "model/frame.h"
#include "model/frame_shard.h"

#include <algorithm>
#include <utility>

namespace ropsim {

namespace {
constexpr std::size_t kChunkFragments = 1 << 18;
}

void Frame::start_group(const TileGroup& group) {
    group_ = &group;
    selected_ = group.selected;
    most_passes_ = std::max(most_passes_, std::exchange(passes_run_, 0));
    most_geometry_passes_ = std::max(most_geometry_passes_, std::exchange(geometry_passes_run_, 0));
    sequence_ = PassSequence(operation_.declaration());
    watched_before_ = 0;
    watched_before_ = watched_count();
    watched_taken_.assign(
        static_cast<std::size_t>(config_.tiles.across) * static_cast<std::size_t>(config_.tiles.down), 0);
    group_tile_ = group_fragment_ = 0;
    next_tile_ = 0;
    forget_chunks();
    stage_ = Stage::kInitialise;
}

void Frame::start_rest() {
    group_ = nullptr;
    selected_.clear();
    trace_.select_tiles({});
    trace_.rewind();
    watched_before_ = 0;
    watched_before_ = watched_count();
    sequence_ = PassSequence(operation_.declaration());
    while (!sequence_.done() && sequence_.pass() < config_.tiles.tiled_passes) sequence_.advance(0);
    next_tile_ = 0;
    if (config_.tiles.tiled_passes == 0)
        stage_ = Stage::kInitialise;
    else
        enter_pass();
}

bool Frame::stops_here() const {
    if (group_ == nullptr) return false;
    return sequence_.done() ? !config_.tiles.tiled_resolve : sequence_.pass() >= config_.tiles.tiled_passes;
}

// How often the path was taken that a repeated pass goes on for: of this group.
std::uint64_t Frame::watched_count() const {
    const int watched = sequence_.watched_path();
    return watched < 0 ? 0 : path_count(static_cast<std::size_t>(watched)) - watched_before_;
}

// Before another round. A round changes nothing in a tile where the one before found nothing to go on for:
// it would find the same.
void Frame::leave_out_finished_tiles(int round_before) {
    if (sequence_.round() == round_before) return;
    if (sequence_.round() == 0) {
        selected_ = group_->selected;
    } else if (sequence_.watched_path() >= 0) {
        for (std::size_t tile = 0; tile < selected_.size(); ++tile)
            selected_[tile] &= watched_taken_[config_.tiles.tile_of(tile)];
    }
    std::ranges::fill(watched_taken_, 0);
}

// The next fragments of the group's tiles that are not left out.
bool Frame::read_group_chunk(FragmentChunk& chunk) {
    chunk.clear();
    const FragmentChunk& all = group_->fragments;
    const auto append = [](auto& to, const auto& from, std::size_t first, std::size_t last) {
        if (from.empty()) return;
        to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(first),
                  from.begin() + static_cast<std::ptrdiff_t>(last));
    };
    while (group_tile_ < group_->tiles.size() && chunk.size() < kChunkFragments) {
        const std::size_t end = group_->first[group_tile_ + 1];
        group_fragment_ = std::max(group_fragment_, group_->first[group_tile_]);
        const Fragment& any = all.fragments[group_fragment_];
        const std::size_t small = static_cast<std::size_t>(any.y / kTileSize) *
                                      static_cast<std::size_t>(config_.tiles.small_across) +
                                  static_cast<std::size_t>(any.x / kTileSize);
        const std::size_t last = std::min(end, group_fragment_ + kChunkFragments - chunk.size());
        if (selected(small)) {
            append(chunk.fragments, all.fragments, group_fragment_, last);
            append(chunk.slopes, all.slopes, group_fragment_, last);
            append(chunk.materials, all.materials, group_fragment_, last);
            group_fragment_ = last;
        } else {
            group_fragment_ = end;
        }
        if (group_fragment_ == end) ++group_tile_;
    }
    return !chunk.empty();
}

void Frame::store_tile(std::size_t tile, QuadBatch& batch) const {
    const int partition = map_.partition_of(tile);
    LineCollector& collector = shards_[static_cast<std::size_t>(partition)]->collector;
    QuadOperation q;
    q.quad_id = static_cast<std::uint32_t>(tile) * 16;
    q.partition = static_cast<std::uint8_t>(partition);
    q.kind = QuadKind::kCopy;
    q.pass = static_cast<std::uint8_t>(operation_.declaration().passes.size() + 1);
    q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
    collector.begin(batch, partition, true);
    if (operation_.declaration().resolves) {
        for (std::uint32_t quad = 0; quad < 16; ++quad) write_image_quad(collector, tile, quad);
    } else {
        const std::vector<std::uint8_t> values = stored_tile(0, tile);
        collector.write(0, map_.tile_address(0, tile), map_.pixel_bytes(0) * kTilePixels, values.data());
    }
    q.line_count = collector.count();
    q.interval = q.line_count;
    batch.quads.push_back(q);
}

// A tile's bytes as the frame leaves them, where someone needs them.
std::vector<std::uint8_t> Frame::stored_tile(int surface, std::size_t tile) const {
    std::vector<std::uint8_t> bytes;
    if (!map_.needs_values(surface)) return bytes;
    const PixelStore& store = shards_[static_cast<std::size_t>(map_.partition_of(tile))]->store;
    FrameContents(map_, operation_.declaration(), store, map_.partition_of(tile)).tile(surface, tile, bytes);
    if (!reached(tile, 1)) return bytes;
    const std::uint32_t element_bytes = map_.element_bytes(surface);
    const std::uint32_t elements = map_.pixel_bytes(surface) / element_bytes;
    const auto across = static_cast<std::size_t>(tiles_across(image_.width));
    std::vector<std::uint8_t> pixel_bytes;
    for (std::uint32_t i = 0; i < kTilePixels; ++i) {
        const std::uint32_t quad = i / 4;
        const std::uint32_t pixel = i % 4;
        const int x =
            static_cast<int>(tile % across) * kTileSize + static_cast<int>(quad % 4 * 2 + pixel % 2);
        const int y =
            static_cast<int>(tile / across) * kTileSize + static_cast<int>(quad / 4 * 2 + pixel / 2);
        if (x >= image_.width || y >= image_.height) continue;
        const std::uint8_t* from =
            stored_values(store, surface, tile, quad, pixel, map_.all_elements_of(surface), pixel_bytes);
        for (std::uint32_t e = 0; e < elements; ++e)
            std::copy_n(from + std::size_t{e} * element_bytes, element_bytes,
                        &bytes[map_.offset_in_tile(surface, quad, pixel, e)]);
    }
    return bytes;
}

}  // namespace ropsim
