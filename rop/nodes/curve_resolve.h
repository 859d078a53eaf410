// From a visibility curve to colour: the sums of equation 2 of Salvi et al. 2011 over a background, their
// normalisation, and the whole of section 4.1's pass over a pixel's list.
#pragma once

#include "rop/lists/fragment_lists.h"
#include "rop/nodes/curve_removal.h"
#include "rop/nodes/insert_in_place.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

// What is accumulated of one pixel or sample.
template <class D>
struct CurveSums {
    Rgb<D> color = {0.0f, 0.0f, 0.0f};  // sum of alpha * colour * visibility
    typename D::Real weight = 0.0f;     // sum of alpha * visibility, where it is kept
    typename D::Real total = 1.0f;      // transmittance of everything

    void add(const Rgb<D>& premultiplied, const typename D::Real& visibility) {
        color = {color.r + visibility * premultiplied.r, color.g + visibility * premultiplied.g,
                 color.b + visibility * premultiplied.b};
    }
};

// The sums over what is behind. `normalised`: the weights are scaled to sum to total alpha, 1 - total, as
// they do where visibility is exact. Weights below the smallest binary16 are taken as none: nothing is
// scaled.
template <class D>
Rgb<D> over_background(const CurveSums<D>& sums, bool normalised, const Rgb<D>& background) {
    using Real = typename D::Real;
    Rgb<D> color = sums.color;
    if (normalised) {
        constexpr float kLeastWeight = 0x1p-24f;
        const Real scale = select(sums.weight < Real(kLeastWeight), Real(1.0f),
                                  (Real(1.0f) - sums.total) / maximum(sums.weight, Real(kLeastWeight)));
        color = {color.r * scale, color.g * scale, color.b * scale};
    }
    return {color.r + sums.total * background.r, color.g + sums.total * background.g,
            color.b + sums.total * background.b};
}

// Mean of a pixel's spatial samples: a tree of adders.
template <class D>
Rgb<D> mean_of_samples(std::array<Rgb<D>, kMaxSpatialSamples>& colors, int samples) {
    using Real = typename D::Real;
    if (samples == 1) return colors[0];
    for (std::size_t count = static_cast<std::size_t>(samples); count > 1; count = (count + 1) / 2)
        for (std::size_t i = 0; i < count / 2; ++i) {
            const Rgb<D>& a = colors[2 * i];
            const Rgb<D>& b = colors[2 * i + 1];
            colors[i] = {a.r + b.r, a.g + b.g, a.b + b.b};
        }
    const Real share = 1.0f / static_cast<float>(samples);
    return {colors[0].r * share, colors[0].g * share, colors[0].b * share};
}

// Adaptive transparency over per-pixel lists: curves in registers, nodes fetched once for making them and
// once more for compositing. The samples of a pixel are worked on side by side, so that a fetch serves all
// that the fragment covers; a step is a fragment at one sample.
class CurvesFromLists {
 public:
    CurvesFromLists(const CurveRules& rules, const FragmentLists& lists, int samples, bool normalised)
        : rules_(rules), lists_(lists), samples_(samples), normalised_(normalised) {}

    template <class D, class P>
    Rgb<D> resolve(D& d, const Background<D>& background, P& pixel) const {
        const std::vector<std::uint32_t>& nodes = lists_.walk(d, pixel);
        FragmentLists::walk_again(pixel, nodes);
        std::array<Rgb<D>, kMaxSpatialSamples> colors;
        for (int m = 0; m < samples_; ++m) {
            const std::vector<std::uint32_t>& list = covering<D>(pixel, nodes, m);
            const Curve<D> curve = built(d, pixel, nodes, list);
            const Rgb<D>& behind =
                samples_ == 1 ? background.mean : background.sample[static_cast<std::size_t>(m)];
            colors[static_cast<std::size_t>(m)] =
                over_background(composited(d, pixel, nodes, list, curve), normalised_, behind);
        }
        return mean_of_samples<D>(colors, samples_);
    }

    // Curve of one sample, for what asks for visibility.
    Curve<PlainDatapath> curve(PlainPixel& pixel, int sample) const {
        PlainDatapath d;
        const std::vector<std::uint32_t>& nodes = lists_.walk(d, pixel);
        return built(d, pixel, nodes, covering<PlainDatapath>(pixel, nodes, sample));
    }

 private:
    enum Step { kInsertStep, kCompositeStep };

    // Places in the list of the fragments that cover sample m.
    template <class D, class P>
    const std::vector<std::uint32_t>& covering(P& pixel, const std::vector<std::uint32_t>& nodes,
                                               int m) const {
        static thread_local std::vector<std::uint32_t> list;
        list.clear();
        for (std::uint32_t i = 0; i < nodes.size(); ++i)
            if (samples_ == 1 || ((lists_.coverage(pixel, nodes, i) >> m) & 1u) != 0) list.push_back(i);
        return list;
    }
    static std::uint32_t place(const std::vector<std::uint32_t>& list, std::uint32_t i) {
        return i < list.size() ? list[i] : 0;
    }
    // Registers hold their values when a step begins.
    static void settle(Curve<PlainDatapath>&) {}
    static void settle(Curve<ChargedDatapath>& curve) {
        for (auto& z : curve.depth) z.ready = 0;
        for (auto& v : curve.transmittance) v.ready = 0;
    }

    template <class D, class P>
    Curve<D> built(D& d, P& pixel, const std::vector<std::uint32_t>& nodes,
                   const std::vector<std::uint32_t>& list) const {
        using Real = typename D::Real;
        Curve<D> curve = Curve<D>::empty(rules_);
        d.steps(kInsertStep, static_cast<std::uint32_t>(list.size()), [&](std::uint32_t i) {
            const auto node = lists_.template read_without_color<D>(pixel, nodes, place(list, i));
            const Real t = Real(1.0f) - node.a;
            if constexpr (!D::kCharged) {
                if (rules_.is_plain()) {
                    insert_one_by_one(ArrayNodes{curve.depth.data(), curve.transmittance.data()}, rules_,
                                      node.z, t);
                    return;
                }
            }
            settle(curve);
            insert_into<D>(curve, rules_, node.z, t);
        });
        settle(curve);
        return curve;
    }
    template <class D, class P>
    CurveSums<D> composited(D& d, P& pixel, const std::vector<std::uint32_t>& nodes,
                            const std::vector<std::uint32_t>& list, const Curve<D>& curve) const {
        using Real = typename D::Real;
        CurveSums<D> sums;
        d.steps(kCompositeStep, static_cast<std::uint32_t>(list.size()), [&](std::uint32_t i) {
            const auto node = lists_.template read<D>(pixel, nodes, place(list, i));
            const Real t = rules_.coplanar == CoplanarRule::kInFront ? Real(1.0f) : Real(1.0f) - node.a;
            const Real visibility = visibility_of<D>(curve, rules_, node.z, t);
            sums.color = {value_of(sums.color.r), value_of(sums.color.g), value_of(sums.color.b)};
            sums.add(node.premultiplied, visibility);
            if (normalised_) sums.weight = Real(value_of(sums.weight)) + visibility * node.a;
        });
        sums.color = {value_of(sums.color.r), value_of(sums.color.g), value_of(sums.color.b)};
        sums.weight = value_of(sums.weight);
        sums.total = curve.transmittance[static_cast<std::size_t>(rules_.nodes) - 1];
        return sums;
    }

    const CurveRules& rules_;
    const FragmentLists& lists_;
    int samples_;
    bool normalised_;
};

}  // namespace ropsim
