// Where the numbers of a visibility map are: in a pixel's surfaces, or in the registers of a resolve that
// walks lists.
#pragma once

#include "rop/technique.h"
#include "rop/visibility/storable.h"

#include <array>
#include <cstddef>

namespace ropsim {

inline constexpr int kMaxMapCells = kMaxElements;  // of a spatial sample

// Cell i is element `first` + i of the field.
template <class P>
struct ElementCells {
    using D = typename P::D;
    P& pixel;
    const Field& field;
    int first;

    typename D::Real load(int i) const { return pixel.load(field, first + i); }
    void put_if(const typename D::Bool& condition, int i, const typename D::Real& sum) const {
        write_if(condition, i, storable_sum(sum));
    }
    // The same in halves, for a sum that one of many cells takes.
    typename D::Real storable_sum(const typename D::Real& sum) const {
        return pixel.as_stored(field, storable(field.format, sum));
    }
    void write_if(const typename D::Bool& condition, int i, const typename D::Real& stored) const {
        pixel.write_if(condition, field, first + i);
        if (value_of(condition)) pixel.put_bits(field, first + i, 0, stored_word(value_of(stored)));
    }
};

// Cell i is channel i of element `element`.
template <class P>
struct ChannelCells {
    using D = typename P::D;
    P& pixel;
    const Field& field;
    int element;

    typename D::Real load(int i) const { return pixel.load(field, element, i); }
    void put_if(const typename D::Bool& condition, int i, const typename D::Real& sum) const {
        pixel.write_if(condition, field, element);
        pixel.put_if(condition, field, element, i, storable_signed(field.format, sum));
    }
};

// Float32 registers: no conversion, a put is a clock enable.
template <class Datapath>
struct RegisterCells {
    using D = Datapath;
    std::array<float, kMaxMapCells>& values;

    typename D::Real load(int i) const { return values[static_cast<std::size_t>(i)]; }
    void put_if(const typename D::Bool& condition, int i, const typename D::Real& sum) const {
        write_if(condition, i, sum);
    }
    typename D::Real storable_sum(const typename D::Real& sum) const { return sum; }
    void write_if(const typename D::Bool& condition, int i, const typename D::Real& stored) const {
        if (value_of(condition)) values[static_cast<std::size_t>(i)] = value_of(stored);
    }
};

}  // namespace ropsim
