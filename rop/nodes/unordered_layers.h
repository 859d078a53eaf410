// Compositing of a few layers in whatever order they are kept: all pairs are compared, then trees; no sort.
#pragma once

#include "rop/technique.h"

#include <array>
#include <cstddef>

namespace ropsim {

template <class D>
Rgb<D> scaled(const typename D::Real& by, const Rgb<D>& c) {
    return {by * c.r, by * c.g, by * c.b};
}
template <class D>
Rgb<D> plus(const Rgb<D>& a, const Rgb<D>& b) {
    return {a.r + b.r, a.g + b.g, a.b + b.b};
}

// Of the first `count` entries, at least one; the array is used up.
template <class D, std::size_t kSize>
Rgb<D> tree_sum(std::array<Rgb<D>, kSize>& term, int count) {
    for (int stride = 1; stride < count; stride *= 2)
        for (int i = 0; i + stride < count; i += 2 * stride)
            term[static_cast<std::size_t>(i)] =
                plus<D>(term[static_cast<std::size_t>(i)], term[static_cast<std::size_t>(i + stride)]);
    return term[0];
}
template <class Real, std::size_t kSize>
Real tree_product(std::array<Real, kSize> factor, int count) {
    for (int stride = 1; stride < count; stride *= 2)
        for (int i = 0; i + stride < count; i += 2 * stride)
            factor[static_cast<std::size_t>(i)] =
                factor[static_cast<std::size_t>(i)] * factor[static_cast<std::size_t>(i + stride)];
    return factor[0];
}

// Premultiplied layers with their own transmittances. Of equal depths the one of lower number is nearer.
template <class D, std::size_t kMost>
struct UnorderedLayers {
    std::array<typename D::Real, kMost> depth{};
    std::array<typename D::Real, kMost> transmittance{};
    std::array<Rgb<D>, kMost> color{};

    // The first `count`, at least one, over a background.
    Rgb<D> over(const Rgb<D>& background, int count) const {
        using Real = typename D::Real;
        Factors factor{};  // [i][j]: what layer j leaves of layer i
        for (int i = 0; i < count; ++i) {
            const auto a = static_cast<std::size_t>(i);
            for (int j = i + 1; j < count; ++j) {
                const auto b = static_cast<std::size_t>(j);
                const auto b_is_nearer = depth[b] < depth[a];
                factor[a][b] = select(b_is_nearer, transmittance[b], Real(1.0f));
                factor[b][a] = select(b_is_nearer, Real(1.0f), transmittance[a]);
            }
        }
        std::array<Rgb<D>, kMost + 1> term{};
        for (int i = 0; i < count; ++i) {
            const auto k = static_cast<std::size_t>(i);
            term[k] = scaled<D>(visibility(factor, i, count), color[k]);
        }
        term[static_cast<std::size_t>(count)] = scaled<D>(tree_product(transmittance, count), background);
        return tree_sum(term, count + 1);
    }

 private:
    using Factors = std::array<std::array<typename D::Real, kMost>, kMost>;

    static typename D::Real visibility(const Factors& factor, int i, int count) {
        std::array<typename D::Real, kMost> others{};
        for (int j = 0; j < count; ++j)
            if (j != i)
                others[static_cast<std::size_t>(j < i ? j : j - 1)] =
                    factor[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
        return count > 1 ? tree_product(others, count - 1) : typename D::Real(1.0f);
    }
};

}  // namespace ropsim
