// Which two neighbours of a sorted list an overflow takes together.
#pragma once

#include "rop/nodes/sorted_insertion.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace ropsim {

// A number that travels with a value through a tree of comparators.
template <class D>
struct Ranked {
    typename D::Real value;
    typename D::Uint number;
};

// The number of the least value, of equal ones the earliest: a tree of comparators, count - 1 in all.
template <class D, std::size_t kSize>
typename D::Uint number_of_least(std::array<Ranked<D>, kSize>& entries, int count) {
    for (; count > 1; count = (count + 1) / 2) {
        for (int i = 0; i + 1 < count; i += 2) {
            const auto a = static_cast<std::size_t>(i);
            const auto smaller = entries[a + 1].value < entries[a].value;
            entries[a / 2] = {select(smaller, entries[a + 1].value, entries[a].value),
                              select(smaller, entries[a + 1].number, entries[a].number)};
        }
        if (count % 2 == 1)
            entries[static_cast<std::size_t>(count / 2)] = entries[static_cast<std::size_t>(count - 1)];
    }
    return entries[0].number;
}

// Whether constant i < index: one line of the index's decoder, a gate.
template <class D>
typename D::Bool below(int i, const typename D::Uint& index) {
    const bool less = static_cast<std::uint32_t>(i) < value_of(index);
    if constexpr (D::kCharged)
        return {less, Ledger::active().charge(Unit::kLogic, index.ready)};
    else
        return less;
}

// The list of N + 1 entries once j - 1 and j have become one at place j - 1: those behind move down a place.
template <class D>
class MergedPlaces {
 public:
    // `nodes`: N, the places that are left. j in 1..N.
    MergedPlaces(int nodes, const typename D::Uint& j) {
        behind_[0] = false;
        for (int i = 1; i <= nodes; ++i) behind_[static_cast<std::size_t>(i)] = inverse(below<D>(i, j));
    }
    // What stands at place i.
    template <class T>
    T at(int i, const T& own, const T& next, const T& merged) const {
        const auto k = static_cast<std::size_t>(i);
        if (i == 0) return select(behind_[1], merged, own);
        return select(behind_[k], next, select(behind_[k + 1], merged, own));
    }
    // Whether place i holds something else than before the fragment's insertion, where `in_front` says that
    // its old entry stood in front of the fragment.
    typename D::Bool changed(int i, const typename D::Bool& in_front) const {
        const auto k = static_cast<std::size_t>(i);
        // In front of the merged place whatever the fragment pushed back, behind it whatever moved back down.
        return select(behind_[k], in_front, either(behind_[k + 1], inverse(in_front)));
    }

 private:
    std::array<typename D::Bool, kMaxNodes + 1> behind_;
};

}  // namespace ropsim
