// One channel of an image, and separable filters over it with the border pixels repeated outwards.
#pragma once

#include "base/parallel.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace ropsim {

// Rows are padded to whole blocks, so that inner loops have a fixed length and vectorise.
template <typename Real>
struct Plane {
    static constexpr int kBlock = 8;
    int width = 0;
    int height = 0;
    int stride = 0;
    std::vector<Real> values;

    Plane() = default;
    Plane(int w, int h)
        : width(w),
          height(h),
          stride((w + kBlock - 1) / kBlock * kBlock),
          values(static_cast<std::size_t>(stride) * static_cast<std::size_t>(h)) {}
    Real* row(int y) { return values.data() + static_cast<std::ptrdiff_t>(y) * stride; }
    const Real* row(int y) const { return values.data() + static_cast<std::ptrdiff_t>(y) * stride; }
};

// Calls work(y) for each row, on all cores.
template <typename Work>
void for_each_row(int height, const Work& work) {
    constexpr int kRows = 16;
    parallel_for(default_threads(), (height + kRows - 1) / kRows, [&](int band) {
        for (int y = band * kRows; y < std::min(height, (band + 1) * kRows); ++y) work(y);
    });
}

// out(x, y) = sum over k of taps[k] * in(x + k - taps.size() / 2, y).
template <typename Real>
Plane<Real> filter_across(const Plane<Real>& in, const std::vector<Real>& taps) {
    const int count = static_cast<int>(taps.size());
    const int radius = count / 2;
    Plane<Real> out(in.width, in.height);
    for_each_row(in.height, [&](int y) {
        std::vector<Real> padded(static_cast<std::size_t>(in.stride + count));
        const Real* source = in.row(y);
        for (int i = 0; i < static_cast<int>(padded.size()); ++i)
            padded[static_cast<std::size_t>(i)] = source[std::clamp(i - radius, 0, in.width - 1)];
        for (int x = 0; x < in.stride; x += Plane<Real>::kBlock) {
            std::array<Real, Plane<Real>::kBlock> sum{};
            for (int k = 0; k < count; ++k) {
                const Real* from = padded.data() + x + k;
                const Real tap = taps[static_cast<std::size_t>(k)];
                for (int i = 0; i < Plane<Real>::kBlock; ++i)
                    sum[static_cast<std::size_t>(i)] += tap * from[i];
            }
            std::copy(sum.begin(), sum.end(), out.row(y) + x);
        }
    });
    return out;
}

// out(x, y) = sum over k of taps[k] * in(x, y + k - taps.size() / 2).
template <typename Real>
Plane<Real> filter_down(const Plane<Real>& in, const std::vector<Real>& taps) {
    const int count = static_cast<int>(taps.size());
    const int radius = count / 2;
    Plane<Real> out(in.width, in.height);
    for_each_row(in.height, [&](int y) {
        for (int x = 0; x < in.stride; x += Plane<Real>::kBlock) {
            std::array<Real, Plane<Real>::kBlock> sum{};
            for (int k = 0; k < count; ++k) {
                const Real* from = in.row(std::clamp(y + k - radius, 0, in.height - 1)) + x;
                const Real tap = taps[static_cast<std::size_t>(k)];
                for (int i = 0; i < Plane<Real>::kBlock; ++i)
                    sum[static_cast<std::size_t>(i)] += tap * from[i];
            }
            std::copy(sum.begin(), sum.end(), out.row(y) + x);
        }
    });
    return out;
}

// Mean over all pixels of value(x, y), added up in a fixed order whatever the number of threads.
template <typename Value>
double mean_of_pixels(int x0, int y0, int x1, int y1, const Value& value) {
    std::vector<double> rows(static_cast<std::size_t>(y1 - y0));
    for_each_row(y1 - y0, [&](int row) {
        double sum = 0;
        for (int x = x0; x < x1; ++x) sum += value(x, y0 + row);
        rows[static_cast<std::size_t>(row)] = sum;
    });
    double total = 0;
    for (const double row : rows) total += row;
    return total / (static_cast<double>(x1 - x0) * (y1 - y0));
}

}  // namespace ropsim
