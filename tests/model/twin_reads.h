// The twin's caches before the shader cores: one cycle's work at every ROP cycle. Shares only the tag store,
// the memory port and which lines a quad asks for.
#pragma once

#include "memory/rop_cache.h"
#include "memory/tlm_memory_port.h"
#include "model/byte_counts.h"
#include "model/front_end_caches.h"

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace ropsim {

class TwinReadCache;

class TwinReadPort : public MemoryPortClient {
 public:
    TwinReadPort(const std::string& name, EventWheel& wheel, int surfaces, std::function<void()> wake)
        : port(name.c_str(), wheel, *this, 64),
          wake_(std::move(wake)),
          bytes_(static_cast<std::size_t>(surfaces)) {}

    TlmMemoryPort port;
    void read(TwinReadCache& cache, std::uint64_t line, const MemoryRequest& request);
    void tick(std::uint64_t cycle);
    bool drained() const { return requests_.empty() && port.in_flight() == 0; }
    const BytesByCause& bytes() const { return bytes_; }

    void memory_done(std::uint32_t id, bool write) override;
    void memory_port_free() override { wake_(); }

 private:
    struct Asked {
        TwinReadCache* cache = nullptr;
        std::uint64_t line = 0;
        std::uint32_t first_sector = 0;
        std::uint32_t bytes = 0;
    };
    std::function<void()> wake_;
    std::vector<Asked> asked_;  // every request ever made: its id is its place
    std::deque<MemoryRequest> requests_;
    std::uint64_t next_ = 0;
    BytesByCause bytes_;
};

class TwinReadCache {
 public:
    // `locate`: the port and the address there of an address of the cache's.
    using Locate = std::function<std::pair<TwinReadPort*, std::uint64_t>(std::uint64_t)>;
    TwinReadCache(const EventWheel& wheel, const ReadCacheConfig& config, Picoseconds period, Locate locate)
        : wheel_(wheel), config_(config), period_(period), locate_(std::move(locate)), cache_(config.cache) {}

    void push(std::vector<LineRead> lines, Picoseconds arrival);
    // The first job's answer is there.
    bool answered(Picoseconds now) const;
    void take() { jobs_.pop_front(); }
    void tick(std::uint64_t cycle);
    void fill(std::uint64_t line, std::uint32_t first_sector, std::uint32_t sectors);
    std::uint32_t sector_bytes() const { return config_.cache.sector_bytes; }
    const RopCacheStatistics& statistics() const { return cache_.statistics(); }

 private:
    struct Job {
        std::vector<LineRead> lines;
        Picoseconds arrival = 0;
        std::size_t looked_up = 0;
        bool done = false;                // every line is looked up
        std::uint64_t answer = 0;         // cycle, without what is on its way
        std::set<std::uint64_t> waiting;  // lines on their way
    };
    bool look_up(Job& job, const LineRead& read);

    const EventWheel& wheel_;
    ReadCacheConfig config_;
    Picoseconds period_;
    Locate locate_;
    RopCache cache_;
    std::deque<Job> jobs_;
    std::set<std::uint64_t> misses_;  // lines on their way
    std::uint64_t tags_free_ = 0;     // cycle
};

}  // namespace ropsim
