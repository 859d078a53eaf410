#include "rop/cost.h"

#include <algorithm>

namespace ropsim {

namespace {

// The most that any path of the pass moves, surface by surface.
ByteCount pass_bytes(const Declaration& declaration, const CostTable& table, std::size_t pass) {
    ByteCount bytes;
    for (std::size_t s = 0; s < declaration.surfaces.size(); ++s) {
        ByteCount most;
        for (const PathCost& path : table) {
            if (path.pass != static_cast<int>(pass)) continue;
            most.read = std::max(most.read, access_bytes(declaration.surfaces[s], path.worst[s].read));
            most.write = std::max(most.write, access_bytes(declaration.surfaces[s], path.worst[s].write));
        }
        bytes.read += most.read;
        bytes.write += most.write;
    }
    return bytes;
}

}  // namespace

ByteCount worst_case_bytes(const Declaration& declaration, const CostTable& table) {
    ByteCount all;
    ByteCount chosen;  // a fragment goes through one of the passes that choose draws
    for (std::size_t pass = 0; pass < declaration.passes.size(); ++pass) {
        if (declaration.passes[pass].kind == PassKind::kImage) continue;
        const ByteCount bytes = pass_bytes(declaration, table, pass);
        if (declaration.passes[pass].draws.empty()) {
            all.read += bytes.read;
            all.write += bytes.write;
        } else {
            chosen.read = std::max(chosen.read, bytes.read);
            chosen.write = std::max(chosen.write, bytes.write);
        }
    }
    return {all.read + chosen.read, all.write + chosen.write};
}

int initiation_interval(const Work& work, const DatapathShape& shape) {
    int interval = 1;
    for (std::size_t u = 0; u < static_cast<std::size_t>(kUnitCount); ++u) {
        const int budget = shape.budget[u];
        if (budget > 0)
            interval = std::max(interval, (static_cast<int>(work.units[u]) + budget - 1) / budget);
    }
    return interval;
}

}  // namespace ropsim
