// Where the spatial samples of a pixel lie: one pattern for every driver, so that traces are comparable.
#pragma once

#include "base/error.h"

#include <array>
#include <span>

namespace ropsim {

// In sixteenths of a pixel from its centre, y down, each from -8 to 7.
struct SamplePosition {
    int x16;
    int y16;
    float x() const { return static_cast<float>(x16) / 16.0f; }
    float y() const { return static_cast<float>(y16) / 16.0f; }
};

// The M positions of M = 1, 2, 4, 8 or 16 samples: Direct3D 11's standard multisample patterns
// (D3D11_STANDARD_MULTISAMPLE_PATTERN), which current GPUs use by default. Anything else is a CHECK.
inline std::span<const SamplePosition> sample_positions(int samples) {
    static constexpr std::array<SamplePosition, 1> kOne{{{0, 0}}};
    static constexpr std::array<SamplePosition, 2> kTwo{{{4, 4}, {-4, -4}}};
    static constexpr std::array<SamplePosition, 4> kFour{{{-2, -6}, {6, -2}, {-6, 2}, {2, 6}}};
    static constexpr std::array<SamplePosition, 8> kEight{
        {{1, -3}, {-1, 3}, {5, 1}, {-3, -5}, {-5, 5}, {-7, -1}, {3, 7}, {7, -7}}};
    static constexpr std::array<SamplePosition, 16> kSixteen{{{1, 1},
                                                              {-1, -3},
                                                              {-3, 2},
                                                              {4, -1},
                                                              {-5, -2},
                                                              {2, 5},
                                                              {5, 3},
                                                              {3, -5},
                                                              {-2, 6},
                                                              {0, -7},
                                                              {-4, -6},
                                                              {-6, 4},
                                                              {-8, 0},
                                                              {7, -4},
                                                              {6, 7},
                                                              {-7, -8}}};
    switch (samples) {
        case 1:
            return kOne;
        case 2:
            return kTwo;
        case 4:
            return kFour;
        case 8:
            return kEight;
        default:
            CHECK(samples == 16, "{} samples", samples);
            return kSixteen;
    }
}

}  // namespace ropsim
