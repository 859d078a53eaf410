// Stored samples in order of their depth: a sorting network in hardware, a short sort in software.
#pragma once

#include "rop/sampling/sample_mask.h"

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>

namespace ropsim {

// Sample numbers in order; the first `count` are to be looked at, in hardware those with `valid`.
template <class D>
struct SampleOrder {
    std::array<typename D::Uint, kMaxElements> sample;
    std::array<typename D::Bool, kMaxElements> valid;
    int count = 0;
};

// Software: the samples of the mask by ascending depth, of equal depths the lower number first. `depth` of a
// sample is depth(s). Insertion, since samples of one surface lie together already.
template <class Depth>
SampleOrder<PlainDatapath> sorted_samples(const SampleMask<PlainDatapath>& mask, int, bool sorts,
                                          Depth depth) {
    SampleOrder<PlainDatapath> order;
    std::array<float, kMaxElements> keys;
    for (std::uint64_t left = mask.bits; left != 0; left &= left - 1) {
        const auto s = static_cast<std::uint32_t>(std::countr_zero(left));
        const float key = sorts ? depth(static_cast<int>(s)) : 0.0f;
        auto at = static_cast<std::size_t>(order.count++);
        for (; at > 0 && keys[at - 1] > key; --at) {
            keys[at] = keys[at - 1];
            order.sample[at] = order.sample[at - 1];
        }
        keys[at] = key;
        order.sample[at] = s;
    }
    return order;
}

namespace detail {
// One compare-and-exchange element: a comparator on (removed, depth, number) and a pair of muxes a field.
inline void exchange(std::array<Wire<float>, kMaxElements>& depth, SampleOrder<ChargedDatapath>& order,
                     bool sorts, std::size_t a, std::size_t b) {
    const auto key = [&](std::size_t i) {
        return std::make_tuple(!order.valid[i].value, sorts ? depth[i].value : 0.0f, order.sample[i].value);
    };
    const int ready = std::max({depth[a].ready, depth[b].ready, order.valid[a].ready, order.valid[b].ready});
    const Wire<bool> swap = {key(b) < key(a), Ledger::active().charge(Unit::kComparator, ready)};
    const auto pick = [&](auto& x, auto& y) {
        const auto low = select(swap, y, x);
        y = select(swap, x, y);
        x = low;
    };
    pick(depth[a], depth[b]);
    pick(order.sample[a], order.sample[b]);
    pick(order.valid[a], order.valid[b]);
}
}  // namespace detail

// Hardware: Batcher's odd-even merge network over all samples, those not in the mask last. Without sorting by
// depth the same network only compacts.
template <class Depth>
SampleOrder<ChargedDatapath> sorted_samples(const SampleMask<ChargedDatapath>& mask, int samples, bool sorts,
                                            Depth depth_of) {
    std::array<Wire<float>, kMaxElements> depth;
    SampleOrder<ChargedDatapath> order;
    order.count = samples;
    for (int s = 0; s < samples; ++s) {
        const auto k = static_cast<std::size_t>(s);
        depth[k] = sorts ? depth_of(s) : Wire<float>(0.0f);
        order.sample[k] = static_cast<std::uint32_t>(s);
        order.valid[k] = mask.test(s);
    }
    const auto size = static_cast<int>(std::bit_ceil(static_cast<unsigned>(samples)));
    for (int p = 1; p < size; p *= 2)
        for (int k = p; k >= 1; k /= 2)
            for (int j = k % p; j + k < size; j += 2 * k)
                for (int i = 0; i < k; ++i) {
                    const int a = i + j;
                    const int b = i + j + k;
                    if (b < samples && a / (2 * p) == b / (2 * p))
                        detail::exchange(depth, order, sorts, static_cast<std::size_t>(a),
                                         static_cast<std::size_t>(b));
                }
    return order;
}

}  // namespace ropsim
