// The hash of a trace's content: XXH3-64 over a canonical serialisation, fed as the fragments pass by.
#pragma once

#include "base/error.h"
#include "traces/trace.h"
#include "traces/trace_header.h"

#include <cstdint>
#include <memory>
#include <string>

#include <xxhash.h>

namespace ropsim {

// Header text, a byte that says whether there is an opaque layer, its colours and depths, then the fragments
// as they lie in memory: independent of how they are chunked, compressed and stored.
class ContentHash {
 public:
    explicit ContentHash(const TraceHeader& header) : state_(XXH3_createState()) {
        CHECK(state_ && XXH3_64bits_reset(state_.get()) == XXH_OK);
        const std::string text = header_content_text(header);
        add(text.data(), text.size());
        const char has_opaque = header.opaque ? 1 : 0;
        add(&has_opaque, 1);
        if (!header.opaque) return;
        add(header.opaque->rgb.data(), header.opaque->rgb.size() * sizeof(float));
        add(header.opaque->depth.data(), header.opaque->depth.size() * sizeof(float));
    }
    void add(const Fragment* fragments, std::size_t count) {
        add(static_cast<const void*>(fragments), count * sizeof(Fragment));
    }
    std::uint64_t value() const { return XXH3_64bits_digest(state_.get()); }

 private:
    void add(const void* data, std::size_t size) { XXH3_64bits_update(state_.get(), data, size); }

    struct Free {
        void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
    };
    std::unique_ptr<XXH3_state_t, Free> state_;
};

}  // namespace ropsim
