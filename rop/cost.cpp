#include "rop/cost.h"

namespace ropsim {

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
