// Which of several choices no other beats in both of two quantities.
#pragma once

#include <span>
#include <vector>

namespace ropsim {

// Two quantities of which less is better.
struct CostAndError {
    double cost = 0;
    double error = 0;
};
// Whether each point is on the Pareto front: no other has less of one and no more of the other. Equal points
// stand or fall together.
std::vector<bool> pareto_front(std::span<const CostAndError> points);

}  // namespace ropsim
