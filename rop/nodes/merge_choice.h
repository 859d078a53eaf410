// Which two neighbours of a full list of layers become one:
//   tail           the last two (Salvi and Vaidyanathan 2014)
//   closest        those of least distance (as in Z3, Jouppi and Chang 1999)
//   least_error    those whose merging changes visibility least: the area between the curve with both and the
//                  curve with one, equation 7 of Salvi et al. 2011
//   transmittance  the layer of least transmittance and its neighbour of less: what the public code named
//                  "opacity merge" does (PixelSyncOIT), because its alpha channel holds transmittance
//   opacity        the layer of least opacity and its neighbour of less: what that name says
#pragma once

#include "base/parameters.h"
#include "rop/nodes/least_pair.h"

#include <algorithm>
#include <array>
#include <string>

namespace ropsim {

class MergeChoice {
 public:
    // Reads `merge`. `layers`: N, the places of the list.
    MergeChoice(Parameters& parameters, int layers) : layers_(layers) {
        const std::string name = parameters.get_choice(
            "merge", "tail", {"tail", "closest", "least_error", "transmittance", "opacity"});
        if (name == "closest") rule_ = Rule::kClosest;
        if (name == "least_error") rule_ = Rule::kLeastError;
        if (name == "transmittance") rule_ = Rule::kTransmittance;
        if (name == "opacity") rule_ = Rule::kOpacity;
    }
    bool is_tail() const { return rule_ == Rule::kTail; }

    // Which entry, 1..N, of the list of N + 1 joins the one in front of it, by depth(i) and the entries' own
    // transmittance(i). Of equals the nearest pair.
    template <class D, class Depth, class Transmittance>
    typename D::Uint farther_of_pair(const Depth& depth, const Transmittance& transmittance) const {
        if (rule_ == Rule::kTail) return typename D::Uint(static_cast<std::uint32_t>(layers_));
        if (rule_ == Rule::kTransmittance || rule_ == Rule::kOpacity)
            return beside_the_least<D>(transmittance);
        std::array<typename D::Real, kMaxNodes + 1> through;
        if (rule_ == Rule::kLeastError) fill_through<D>(through, transmittance);
        std::array<Ranked<D>, kMaxNodes + 1> ranked;
        for (int j = 1; j <= layers_; ++j) {
            const auto k = static_cast<std::size_t>(j);
            auto error = depth(j) - depth(j - 1);
            if (rule_ == Rule::kLeastError) error = (through[k - 1] - through[k]) * error;
            ranked[k - 1] = {error, static_cast<std::uint32_t>(j)};
        }
        return number_of_least(ranked, layers_);
    }

 private:
    enum class Rule : std::uint8_t { kTail, kClosest, kLeastError, kTransmittance, kOpacity };

    template <class D, class Transmittance>
    typename D::Uint beside_the_least(const Transmittance& transmittance) const {
        using Uint = typename D::Uint;
        std::array<typename D::Real, kMaxNodes + 1> value;
        for (int i = 0; i <= layers_; ++i) {
            const auto t = transmittance(i);
            value[static_cast<std::size_t>(i)] = rule_ == Rule::kOpacity ? negative(t) : t;
        }
        std::array<Ranked<D>, kMaxNodes + 1> ranked;
        for (int i = 0; i <= layers_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const auto number = static_cast<std::uint32_t>(i);
            Uint far = std::max(number, 1u);  // the first and the last have one neighbour
            if (i > 0 && i < layers_)
                far = select(value[k - 1] < value[k + 1], Uint(number), Uint(number + 1));
            ranked[k] = {value[k], far};
        }
        return number_of_least(ranked, layers_ + 1);
    }

    // The transmittance of all entries up to and with each: a tree of multipliers.
    template <class D, class Transmittance>
    void fill_through(std::array<typename D::Real, kMaxNodes + 1>& through,
                      const Transmittance& transmittance) const {
        for (int i = 0; i <= layers_; ++i) through[static_cast<std::size_t>(i)] = transmittance(i);
        for (int stride = 1; stride <= layers_; stride *= 2)
            for (int i = layers_; i >= stride; --i)
                through[static_cast<std::size_t>(i)] =
                    through[static_cast<std::size_t>(i - stride)] * through[static_cast<std::size_t>(i)];
    }

    int layers_;
    Rule rule_ = Rule::kTail;
};

}  // namespace ropsim
