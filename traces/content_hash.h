// The hash of a trace's content: XXH3-64 over a canonical serialisation, fed as the fragments pass by.
#pragma once

#include "base/error.h"
#include "traces/trace.h"
#include "traces/trace_header.h"

#include <cstdint>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <xxhash.h>

namespace ropsim {

// XXH3-64 of bytes that come in pieces.
class RunningHash {
 public:
    RunningHash() : state_(XXH3_createState()) { CHECK(state_ && XXH3_64bits_reset(state_.get()) == XXH_OK); }
    void add(const void* data, std::size_t size) { XXH3_64bits_update(state_.get(), data, size); }
    std::uint64_t value() const { return XXH3_64bits_digest(state_.get()); }

 private:
    struct Free {
        void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
    };
    std::unique_ptr<XXH3_state_t, Free> state_;
};

// Of header text, a byte that says whether there is an opaque layer, its colours and depths, then the
// fragments as they lie in memory; of slopes and materials apart, so that a reader may leave them out:
// independent of how all that is chunked, compressed and stored.
class ContentHash {
 public:
    explicit ContentHash(const TraceHeader& header) : header_(&header) {
        const std::string text = header_content_text(header);
        fragments_.add(text.data(), text.size());
        const char has_opaque = header.opaque ? 1 : 0;
        fragments_.add(&has_opaque, 1);
        if (!header.opaque) return;
        fragments_.add(header.opaque->rgb.data(), header.opaque->rgb.size() * sizeof(float));
        fragments_.add(header.opaque->depth.data(), header.opaque->depth.size() * sizeof(float));
    }
    void add(const FragmentChunk& chunk) {
        fragments_.add(chunk.fragments.data(), chunk.fragments.size() * sizeof(Fragment));
        slopes_.add(chunk.slopes.data(), chunk.slopes.size() * sizeof(DepthSlope));
        materials_.add(chunk.materials.data(), chunk.materials.size() * sizeof(Material));
    }
    std::uint64_t fragments() const { return fragments_.value(); }
    std::uint64_t slopes() const { return header_->depth_slopes ? slopes_.value() : 0; }
    std::uint64_t materials() const { return header_->materials ? materials_.value() : 0; }

 private:
    const TraceHeader* header_;
    RunningHash fragments_, slopes_, materials_;
};

// The hash of the whole content as users see it: that of the fragments where there is nothing else.
inline std::string hash_text(const TraceHeader& header, std::uint64_t fragments, std::uint64_t slopes,
                             std::uint64_t materials) {
    if (!header.depth_slopes && !header.materials) return fmt::format("{:016x}", fragments);
    const std::uint64_t all[3] = {fragments, slopes, materials};
    return fmt::format("{:016x}", XXH3_64bits(all, sizeof(all)));
}

}  // namespace ropsim
