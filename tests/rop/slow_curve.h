// Adaptive transparency's curve kept the slow way, with nothing of the techniques: a vector that is searched,
// inserted into and erased from, one removal after the other tried out.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace ropsim::test {

struct SlowCurve {
    struct Node {
        float z, t;
    };
    std::size_t most_nodes = 8;
    std::string removal = "underestimate";
    std::string candidates = "paper";
    std::string equal_depth = "in_front";
    std::vector<Node> nodes;
    bool equation_7_for_both = false;  // overestimation's error as printed: that of underestimation

    void insert(float z, float t) {
        std::size_t at = 0;
        while (at < nodes.size() && (nodes[at].z < z || (equal_depth == "behind" && nodes[at].z == z))) ++at;
        const float before = at == 0 ? 1.0f : nodes[at - 1].t;
        const bool merges = equal_depth == "merge" && at < nodes.size() && nodes[at].z == z;
        for (std::size_t j = at; j < nodes.size(); ++j) nodes[j].t *= t;
        if (!merges) nodes.insert(nodes.begin() + static_cast<std::ptrdiff_t>(at), {z, before * t});
        if (nodes.size() > most_nodes) remove_one();
    }

    float in_front(float z) const {
        float t = 1;
        for (const Node& n : nodes)
            if (n.z < z) t = n.t;
        return t;
    }

 private:
    // The area between the curve and what it would be, where removal says how it may become.
    void remove_one() {
        const std::size_t n = most_nodes;
        std::size_t first = 0;
        if (candidates == "protect_front_half" && n >= 8) first = n / 2;
        const std::size_t last = candidates == "paper" ? n : n - 1;
        float least = std::numeric_limits<float>::infinity();
        std::size_t chosen = 0;
        bool lowers = false;
        for (std::size_t j = first; j <= last; ++j) {
            const float height = (j == 0 ? 1.0f : nodes[j - 1].t) - nodes[j].t;
            if (removal != "overestimate" && j > 0) {
                const float area = height * (nodes[j].z - nodes[j - 1].z);
                if (area < least) {
                    least = area;
                    chosen = j;
                    lowers = true;
                }
            }
            if (removal != "underestimate" && !(equation_7_for_both && j == 0)) {
                const float width = equation_7_for_both ? nodes[j].z - nodes[j - 1].z
                                                        : (j == n ? 1.0f : nodes[j + 1].z) - nodes[j].z;
                const float area = height * width;
                if (area < least) {
                    least = area;
                    chosen = j;
                    lowers = false;
                }
            }
        }
        if (lowers) nodes[chosen - 1].t = nodes[chosen].t;
        nodes.erase(nodes.begin() + static_cast<std::ptrdiff_t>(chosen));
    }
};

}  // namespace ropsim::test
