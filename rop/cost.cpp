#include "rop/cost.h"

#include <algorithm>

namespace ropsim {

ByteCount worst_case_bytes(const Declaration& declaration, const CostTable& table) {
    ByteCount bytes;
    for (std::size_t pass = 0; pass < declaration.passes.size(); ++pass) {
        if (declaration.passes[pass].kind == PassKind::kImage) continue;
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
    }
    return bytes;
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
