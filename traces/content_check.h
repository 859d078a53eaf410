// Compares what was read of a trace with what its index says: the content hash and the fragments of every
// tile.
#pragma once

#include "traces/content_hash.h"
#include "traces/trace_index.h"

#include <memory>
#include <vector>

namespace ropsim {

// Once a pass over all fragments has been right, later ones cost nothing. `index` must outlive it.
class ContentCheck {
 public:
    explicit ContentCheck(const TraceIndex& index) : index_(index) {}

    // A new pass; `whole` where all fragments will be read.
    void start(bool whole) {
        const TraceHeader& header = index_.stored.header;
        const bool has_channels = header.depth_slopes || header.materials;
        hash_.reset();
        every_channel_ = true;
        if (!whole || (fragments_right_ && (channels_right_ || !has_channels))) return;
        hash_ = std::make_unique<ContentHash>(header);
        tiles_.assign(index_.tiles.size(), 0);
    }
    void add(const FragmentChunk& chunk) {
        if (!hash_) return;
        const TraceHeader& header = index_.stored.header;
        every_channel_ = every_channel_ && chunk.slopes.empty() != header.depth_slopes &&
                         chunk.materials.empty() != header.materials;
        hash_->add(chunk);
        const auto columns = static_cast<std::size_t>(tiles_across(header.width));
        for (const Fragment& f : chunk.fragments)
            ++tiles_[static_cast<std::size_t>(f.y / kTileSize) * columns + f.x / kTileSize];
    }
    // After the last chunk. Throws FormatFault; channels that were not read in every chunk are not judged.
    void finish() {
        if (!hash_) return;
        const bool channels_match = !every_channel_ || (hash_->slopes() == index_.totals.slope_hash &&
                                                        hash_->materials() == index_.totals.material_hash);
        if (hash_->fragments() != index_.totals.hash || !channels_match)
            throw FormatFault("does not match its hash");
        if (tiles_ != index_.tiles) throw FormatFault("is not in the tiles that the index says");
        fragments_right_ = true;
        channels_right_ = channels_right_ || every_channel_;
        hash_.reset();
    }

 private:
    const TraceIndex& index_;
    bool fragments_right_ = false;
    bool channels_right_ = false;
    std::unique_ptr<ContentHash> hash_;  // of this pass; none where there is nothing to check
    std::vector<std::uint64_t> tiles_;
    bool every_channel_ = true;  // has been read in this pass
};

}  // namespace ropsim
