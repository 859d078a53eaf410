// Sampled stack distances: see reuse_sample.h.
#include "model/reuse_sample.h"

#include <algorithm>
#include <bit>

namespace ropsim {

ReuseSample::ReuseSample(const RopCacheConfig& cache, const SurfaceMap& map)
    : size_bytes_(cache.size_bytes),
      line_shift_(std::countr_zero(cache.line_bytes)),
      section_of_(static_cast<std::size_t>(map.surfaces())) {
    std::array<std::uint32_t, kCacheSections> bytes = cache.section_bytes;
    if (bytes[0] == 0) bytes = {cache.size_bytes, 0, 0};
    std::uint32_t smallest = cache.size_bytes;
    for (const std::uint32_t b : bytes)
        if (b != 0) smallest = std::min(smallest, b);
    const std::uint32_t lines = smallest >> line_shift_;
    sampled_shift_ = std::bit_width(std::max(lines / kSampled, 1u)) - 1;
    for (std::size_t s = 0; s < section_of_.size(); ++s) {
        const auto section = static_cast<std::size_t>(map.surface_class(static_cast<int>(s)));
        if (cache.section_bytes[0] != 0)
            section_of_[s] = static_cast<std::uint8_t>(bytes[section] != 0 ? section : 1);
    }
    for (int p = 0; p < map.partitions(); ++p) {
        for (const std::uint32_t b : bytes) {
            std::vector<std::uint32_t> capacities;
            // A section that nobody uses needs some capacities, too.
            const std::uint32_t sampled = std::max(b >> line_shift_ >> sampled_shift_, 4u);
            for (const std::uint32_t eighths : kEighths) capacities.push_back(sampled * eighths / 8);
            sections_.push_back({LruStack(capacities), {}, 0});
        }
    }
}

void ReuseSample::use(const QuadBatch& batch) {
    // Most lines are not of the sample: what tells so is kept in registers.
    const int line_shift = line_shift_;
    const std::uint64_t chosen = ~std::uint64_t{0} >> sampled_shift_;
    for (std::size_t p = 0; p < batch.lines.size(); ++p) {
        for (const LineAccess& access : batch.lines[p]) {
            const std::uint64_t line = access.line_address >> line_shift;
            // Other lines in each partition: their errors average out.
            const std::uint64_t hash = (line + (p << 32)) * 0x9E3779B97F4A7C15u;
            if (hash > chosen) continue;
            Section& section = sections_[p * kCacheSections + section_of_[access.surface]];
            if (line >= section.number.size()) section.number.resize(line + line / 2 + 1);
            std::uint32_t& number = section.number[line];
            const bool before = number != 0;
            if (!before) number = ++section.lines;
            const int level = section.stack.use(number - 1);
            if (before && access.read_sectors != 0) ++reads_[static_cast<std::size_t>(level)];
        }
    }
}

ReuseCounts ReuseSample::counts() const {
    ReuseCounts counts;
    counts.every = 1u << sampled_shift_;
    for (const std::uint64_t reads : reads_) counts.reads += reads;
    std::uint64_t hits = 0;
    for (std::size_t i = 0; i < kEighths.size(); ++i) {
        hits += reads_[i];
        counts.sizes.push_back({size_bytes_ * kEighths[i] / 8, counts.reads - hits});
    }
    return counts;
}

}  // namespace ropsim
