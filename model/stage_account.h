// Where a stage's cycles went: every cycle has exactly one label.
#pragma once

#include "base/error.h"

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace ropsim {

enum class StageLabel : std::uint8_t {
    kBusy,
    kIdle,            // nothing to do
    kShading,         // front end: the next quad in raster order is still being shaded
    kRopQueueFull,    // front end: the next quad's partition has no room
    kInterlock,       // an earlier quad on the same pixels is not written yet
    kSlotsFull,       // as many quads in flight as there are slots
    kMshrsFull,       // no miss register left
    kRequestQueue,    // the queue between cache and memory is full
    kCacheWays,       // every way of the set waits for its fill
    kFill,            // operands are on their way from memory
    kCacheRead,       // operands are on their way from the cache
    kMemoryFull,      // memory does not take the next request
    kMetadata,        // the state of a block in memory is on its way
    kEvictionBuffer,  // every place for blocks on their way to memory is taken, or the block asked for is one
    kStores,          // engine shader: stores are on their way, and the word that they have arrived
    kCount,
};
inline constexpr int kStageLabels = static_cast<int>(StageLabel::kCount);
inline constexpr std::array<std::string_view, kStageLabels> kStageLabelNames = {
    "busy",       "idle",        "shading",       "rop_queue_full",  "interlock",
    "slots_full", "mshrs_full",  "request_queue", "cache_ways",      "fill",
    "cache_read", "memory_full", "metadata",      "eviction_buffer", "stores"};

// A stretch of cycles with one label, from where the stretch before it ended.
struct StageSpan {
    std::uint64_t until;
    StageLabel label;
};

// Time runs in cycles of the stage. charge(until, label) gives every cycle not yet labelled before `until`
// its label.
class StageAccount {
 public:
    void charge(std::uint64_t until, StageLabel label) {
        // Without a branch: whether there is something to label is as good as random.
        const std::uint64_t end = until > labelled_ ? until : labelled_;
        cycles_[static_cast<std::size_t>(label)] += end - labelled_;
        if (log_ != nullptr && end != labelled_) [[unlikely]]
            append(end, label);
        labelled_ = end;
    }
    std::uint64_t labelled() const { return labelled_; }
    std::uint64_t cycles(StageLabel label) const { return cycles_[static_cast<std::size_t>(label)]; }
    // Labels the rest idle and checks that the labels sum to the total.
    void finish(std::uint64_t total) {
        charge(total, StageLabel::kIdle);
        std::uint64_t sum = 0;
        for (const std::uint64_t c : cycles_) sum += c;
        CHECK(sum == total && labelled_ == total, "labels sum to {}, stage ran {} of {} cycles", sum,
              labelled_, total);
    }
    // Every stretch from now on is also appended to `log`, which its owner empties.
    void set_log(std::vector<StageSpan>* log) { log_ = log; }
    void add(const StageAccount& other) {
        for (std::size_t l = 0; l < cycles_.size(); ++l) cycles_[l] += other.cycles_[l];
        labelled_ += other.labelled_;
    }

 private:
    // Apart, so that charge() stays small enough to be inlined.
    [[gnu::noinline]] void append(std::uint64_t until, StageLabel label) { log_->push_back({until, label}); }

    std::array<std::uint64_t, kStageLabels> cycles_{};
    std::uint64_t labelled_ = 0;
    std::vector<StageSpan>* log_ = nullptr;
};

}  // namespace ropsim
