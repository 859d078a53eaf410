// One pass over the points by ascending cost.
#include "analysis/pareto_front.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>

namespace ropsim {

std::vector<bool> pareto_front(std::span<const CostAndError> points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return points[a].cost != points[b].cost ? points[a].cost < points[b].cost
                                                : points[a].error < points[b].error;
    });
    std::vector<bool> front(points.size(), false);
    std::optional<CostAndError> last;  // on the front, at a cost no greater
    for (const std::size_t i : order) {
        const CostAndError& p = points[i];
        front[i] = !last || p.error < last->error || (p.error == last->error && p.cost == last->cost);
        if (front[i]) last = p;
    }
    return front;
}

}  // namespace ropsim
