// What a reader of few tiles has decoded, kept for its next pass over the trace.
#pragma once

#include "traces/trace.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace ropsim {

// A reader decodes whole regions to get at a few tiles: with many passes that costs more than to remember the
// tiles' fragments. They are kept as long as they fit.
class KeptChunks {
 public:
    static constexpr std::uint64_t kMostBytes = std::uint64_t{512} << 20;

    // A pass begins, over the same tiles (or, `anew`, not), to be kept or not.
    void rewind(bool anew, bool keeping) {
        if (anew || !complete_) {
            chunks_.clear();
            bytes_ = 0;
            complete_ = false;
            keeps_ = keeping;
        }
        next_ = 0;
    }
    // Whether all of the last pass is here with these channels.
    bool holds(unsigned channels) const { return complete_ && channels == channels_; }
    // The next of them; false at the end.
    bool next(FragmentChunk& out) {
        if (next_ == chunks_.size()) return false;
        out = chunks_[next_++];
        return true;
    }
    void keep(const FragmentChunk& chunk, unsigned channels) {
        if (complete_ || !keeps_) return;
        keeps_ = chunks_.empty() || channels == channels_;
        channels_ = channels;
        bytes_ += chunk.size() * (sizeof(Fragment) + (chunk.slopes.empty() ? 0 : sizeof(DepthSlope)) +
                                  (chunk.materials.empty() ? 0 : sizeof(Material)));
        keeps_ = keeps_ && bytes_ <= kMostBytes;
        if (keeps_)
            chunks_.push_back(chunk);
        else
            std::exchange(chunks_, {});
    }
    // The pass has come to its end.
    void finish() { complete_ = complete_ || keeps_; }

 private:
    std::vector<FragmentChunk> chunks_;
    std::size_t next_ = 0;
    std::uint64_t bytes_ = 0;
    unsigned channels_ = 0;
    bool keeps_ = false;
    bool complete_ = false;
};

}  // namespace ropsim
