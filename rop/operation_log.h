// What operations did: totals for every fidelity, and one record an operation where timing follows.
#pragma once

#include "rop/declaration.h"
#include "rop/gather_reads.h"
#include "rop/pixel.h"
#include "rop/stored_bytes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

namespace ropsim {

// Bits set, without the library call that std::popcount is on processors a build may not assume: it would be
// a tenth of a fragment's time.
inline std::uint64_t count_elements(std::uint64_t mask) {
    if (mask <= 1) return mask;  // most surfaces have one element a pixel, or none that is touched
    mask -= (mask >> 1) & 0x5555555555555555ull;
    mask = (mask & 0x3333333333333333ull) + ((mask >> 2) & 0x3333333333333333ull);
    mask = (mask + (mask >> 4)) & 0x0F0F0F0F0F0F0F0Full;
    return (mask * 0x0101010101010101ull) >> 56;
}

// One log a partition; totals are sums, so logs add up in any order.
class OperationLog {
 public:
    // `values`: of recorded operations, also the bytes written to the surfaces with a 1 here (empty: none).
    // The declaration must outlive the log then.
    OperationLog(const Declaration& declaration, bool record, std::vector<std::uint8_t> values = {})
        : path_count_(declaration.paths.size()),
          path_steps_(declaration.paths.size()),
          accesses_of_(declaration.surfaces.size()),
          surfaces_(declaration.surfaces.size()),
          pool_(surfaces_),
          record_(record),
          values_of_(std::move(values)),
          keeps_values_(std::ranges::find(values_of_, 1) != values_of_.end()),
          declaration_(declaration) {
        for (std::size_t s = 0; s < surfaces_; ++s) {
            pool_[s] = declaration.surfaces[s].layout == Layout::kPool;
            pixel_elements_[s] = static_cast<std::uint64_t>(declaration.surfaces[s].elements);
        }
    }

    // `read_pixels`: the operation read the same elements of so many pixels (of a window).
    [[gnu::always_inline]] void add(int path, const PixelAccess& access,
                                    const std::array<std::uint32_t, 2>& steps,
                                    std::uint64_t read_pixels = 1) {
        const auto p = static_cast<std::size_t>(path);
        ++path_count_[p];
        if (std::bit_cast<std::uint64_t>(steps) != 0) {
            path_steps_[p][0] += steps[0];
            path_steps_[p][1] += steps[1];
        }
        for (std::size_t s = 0; s < surfaces_; ++s) {
            // Elements of few are counted at the end, by mask.
            if ((access[s].read | access[s].write) < kMasks) [[likely]] {
                accesses_of_[s].read[access[s].read] += read_pixels;
                ++accesses_of_[s].written[access[s].write];
                continue;
            }
            read_elements_[s] += count_elements(access[s].read) * read_pixels;
            write_elements_[s] += pool_[s] ? access[s].write != 0 : count_elements(access[s].write);
        }
        if (record_) [[unlikely]]
            record(path, access, steps);
    }
    bool keeps_values() const { return keeps_values_; }
    // The operation added last left these words: of the pixel, and of the node it wrote, if any.
    void keep_values(const std::uint32_t* words, const PixelAccess& access, NodePool* pool);
    // Written elements' stored bytes, by record, surface and element.
    const std::vector<std::uint8_t>& values() const { return values_; }

    // A list walk read these nodes of pool surface `surface`, in this order.
    void add_walk(std::size_t surface, const std::vector<std::uint32_t>& nodes) {
        read_elements_[surface] += nodes.size();
        if (record_) {
            walk_nodes_.insert(walk_nodes_.end(), nodes.begin(), nodes.end());
            walk_lengths_.push_back(static_cast<std::uint32_t>(nodes.size()));
        }
    }

    // What the operation added last gathered from other pixels.
    void add_gather(const GatherReads& gather) {
        for (std::size_t s = 0; s < surfaces_; ++s)
            read_elements_[s] += gather.pixels[s] * pixel_elements_[s];
        backgrounds_ += gather.backgrounds;
        opaque_depths_ += gather.opaque_depths;
        if (!record_) return;
        gather_reads_.insert(gather_reads_.end(), gather.reads.begin(), gather.reads.end());
        gather_lengths_.push_back(static_cast<std::uint32_t>(gather.reads.size()));
    }
    bool records_all() const { return record_; }
    // Gathered of the opaque layer: colours and depths.
    std::uint64_t backgrounds() const { return backgrounds_; }
    std::uint64_t opaque_depths() const { return opaque_depths_; }
    const std::vector<GatherRead>& gather_reads() const { return gather_reads_; }
    const std::vector<std::uint32_t>& gather_lengths() const { return gather_lengths_; }  // by record

    std::uint64_t path_count(std::size_t path) const { return path_count_[path]; }
    const std::array<std::uint64_t, 2>& path_steps(std::size_t path) const { return path_steps_[path]; }
    std::uint64_t read_elements(std::size_t surface) const {
        return read_elements_[surface] + elements_of(accesses_of_[surface].read);
    }
    std::uint64_t write_elements(std::size_t surface) const {
        const ByMask& written = accesses_of_[surface].written;
        // Of a pool it is no mask but the node's number.
        return write_elements_[surface] + (pool_[surface] ? written_nodes(written) : elements_of(written));
    }

    // Records since the last clear_records(), in order of operation.
    std::size_t records() const { return records_; }
    std::uint8_t record_path(std::size_t i) const { return paths_[i]; }
    const SurfaceAccess* record_access(std::size_t i) const { return &accesses_[i * surfaces_]; }
    const std::array<std::uint32_t, 2>& record_steps(std::size_t i) const { return steps_[i]; }
    const std::vector<std::uint32_t>& walk_nodes() const { return walk_nodes_; }
    const std::vector<std::uint32_t>& walk_lengths() const { return walk_lengths_; }
    void clear_records() {
        records_ = 0;
        walk_nodes_.clear();
        walk_lengths_.clear();
        gather_reads_.clear();
        gather_lengths_.clear();
        values_.clear();
    }

 private:
    // Accesses by mask of elements.
    static constexpr std::uint64_t kMasks = 256;
    using ByMask = std::array<std::uint64_t, kMasks>;
    struct Accesses {
        ByMask read{};
        ByMask written{};
    };
    static std::uint64_t elements_of(const ByMask& accesses) {
        std::uint64_t elements = 0;
        for (std::uint64_t mask = 0; mask < kMasks; ++mask) elements += accesses[mask] * count_elements(mask);
        return elements;
    }
    static std::uint64_t written_nodes(const ByMask& accesses) {
        std::uint64_t nodes = 0;
        for (std::uint64_t node = 1; node < kMasks; ++node) nodes += accesses[node];
        return nodes;
    }
    [[gnu::noinline]] void record(int path, const PixelAccess& access,
                                  const std::array<std::uint32_t, 2>& steps) {
        if (records_ == paths_.size()) [[unlikely]]
            make_room();
        paths_[records_] = static_cast<std::uint8_t>(path);
        steps_[records_] = steps;
        // So few that a loop is faster than the library's copy.
        SurfaceAccess* const accesses = &accesses_[records_ * surfaces_];
        for (std::size_t s = 0; s < surfaces_; ++s) accesses[s] = access[s];
        ++records_;
    }
    void make_room();

    std::vector<std::uint64_t> path_count_;
    std::vector<std::array<std::uint64_t, 2>> path_steps_;
    std::array<std::uint64_t, kMaxTechniqueSurfaces> read_elements_{};
    std::array<std::uint64_t, kMaxTechniqueSurfaces> write_elements_{};
    std::vector<Accesses> accesses_of_;  // by surface; what is not in these sums
    std::uint64_t backgrounds_ = 0;
    std::uint64_t opaque_depths_ = 0;
    std::size_t surfaces_;
    std::array<std::uint64_t, kMaxTechniqueSurfaces> pixel_elements_{};
    std::vector<std::uint8_t> pool_;
    bool record_;
    std::vector<std::uint8_t> values_of_;  // by surface
    bool keeps_values_;
    const Declaration& declaration_;
    std::vector<std::uint8_t> values_;
    // The first `records_` are records, the others room for more.
    std::size_t records_ = 0;
    std::vector<std::uint8_t> paths_;
    std::vector<SurfaceAccess> accesses_;
    std::vector<std::array<std::uint32_t, 2>> steps_;
    std::vector<std::uint32_t> walk_nodes_;
    std::vector<std::uint32_t> walk_lengths_;
    std::vector<GatherRead> gather_reads_;
    std::vector<std::uint32_t> gather_lengths_;
};

}  // namespace ropsim
