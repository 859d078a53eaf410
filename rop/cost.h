// The cost of an operation in hardware: one entry a control path.
#pragma once

#include "rop/datapath.h"
#include "rop/pixel.h"

#include <array>
#include <string>
#include <vector>

namespace ropsim {

inline constexpr int kResolvePass = -1;

struct PathCost {
    std::string name;
    int pass = 0;                // index of the pass it belongs to, or kResolvePass
    Work work;                   // without steps
    std::array<Work, 2> step{};  // of a list: work of one step of each kind
    std::array<bool, 2> has_step{};
    PixelAccess worst{};  // elements read and written when every predicated access happens
    // Cycles between starts in one lane: the busiest unit's count over its budget, at least 1.
    int interval = 1;
    std::array<int, 2> step_interval{};
    int latency() const { return work.latency; }

    // Occupancy and latency of an operation that took `steps` list steps.
    std::uint64_t interval_cycles(const std::array<std::uint32_t, 2>& steps) const {
        return static_cast<std::uint64_t>(interval) +
               static_cast<std::uint64_t>(steps[0]) * static_cast<std::uint64_t>(step_interval[0]) +
               static_cast<std::uint64_t>(steps[1]) * static_cast<std::uint64_t>(step_interval[1]);
    }
    std::uint64_t latency_cycles(const std::array<std::uint32_t, 2>& steps) const {
        return static_cast<std::uint64_t>(work.latency) +
               static_cast<std::uint64_t>(steps[0]) * static_cast<std::uint64_t>(step[0].latency) +
               static_cast<std::uint64_t>(steps[1]) * static_cast<std::uint64_t>(step[1].latency);
    }
};

// Indexed by path number of the declaration.
using CostTable = std::vector<PathCost>;

// Bytes a surface access moves when nothing is cached.
inline std::uint64_t access_bytes(const Surface& surface, std::uint64_t elements) {
    if (surface.layout == Layout::kPool)
        return elements != 0 ? static_cast<std::uint64_t>(surface.element_bytes()) : 0;
    return static_cast<std::uint64_t>(std::popcount(elements)) *
           static_cast<std::uint64_t>(surface.element_bytes());
}

struct ByteCount {
    std::uint64_t read = 0;
    std::uint64_t write = 0;
};
// What one fragment moves at worst through all passes over the fragments, one round each, when nothing is
// cached: for each pass and surface the most that any control path does. Depth test, initial copies and
// resolve are not in it. The papers' model of bandwidth (Salvi et al. 2011, section 5.4).
ByteCount worst_case_bytes(const Declaration& declaration, const CostTable& table);

// Interval of `work` on `shape`: cycles for which the busiest kind of unit is taken.
int initiation_interval(const Work& work, const DatapathShape& shape);

}  // namespace ropsim
