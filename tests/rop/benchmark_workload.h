// What the benchmarks of operations run on, and how they are timed.
#pragma once

#include "tests/rop/random_fragments.h"

#include <chrono>

namespace ropsim::test {

inline constexpr int kWorkloadSide = 128;

// Fragments as hair makes them: strands of 40 pixels, one fragment a pixel, depth and colour changing slowly.
inline std::vector<Fragment> strands(std::size_t count) {
    Random random(1);
    std::vector<Fragment> fragments;
    for (std::uint32_t strand = 0; fragments.size() < count; ++strand) {
        double x = random.unit() * kWorkloadSide;
        double y = random.unit() * kWorkloadSide;
        double z = 0.1 + 0.8 * random.unit();
        const double angle = 6.2831853 * random.unit();
        const float a = random.real(0.2, 0.6);
        for (int i = 0; i < 40 && fragments.size() < count; ++i) {
            x = std::clamp(x + std::cos(angle), 0.0, kWorkloadSide - 1.0);
            y = std::clamp(y + std::sin(angle), 0.0, kWorkloadSide - 1.0);
            z += 1e-3 * (random.unit() - 0.5);
            fragments.push_back(fragment_at(static_cast<int>(x), static_cast<int>(y), static_cast<float>(z),
                                            a, {0.5f, 0.4f, 0.3f}, strand));
        }
    }
    return fragments;
}

inline const std::vector<Fragment>& workload() {
    static const std::vector<Fragment> fragments = strands(std::size_t{kWorkloadSide} * kWorkloadSide * 30);
    return fragments;
}

inline double seconds_of(const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace ropsim::test
