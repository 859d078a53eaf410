// The part of a node that moves from place to place of a list without being looked at: its words as they are
// stored. They cost no conversion on their way, and one mux a place for each 32 bits.
#pragma once

#include "rop/saturated.h"
#include "rop/technique.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace ropsim {

// Functional words of some fields of one element, field after field.
inline constexpr std::size_t kMostStoredWords = 8;
using StoredWords = std::array<std::uint32_t, kMostStoredWords>;

// On the charged datapath: when they are ready, and how many 32-bit words of memory they are.
struct StoredWire {
    StoredWords words{};
    int ready = 0;
    int width = 1;
};

template <class D>
using Moved = std::conditional_t<D::kCharged, StoredWire, StoredWords>;

inline StoredWire select(const Wire<bool>& condition, const StoredWire& a, const StoredWire& b) {
    const int operands = std::max({condition.ready, a.ready, b.ready});
    int ready = operands;
    for (int i = 0; i < a.width; ++i) ready = Ledger::active().charge(Unit::kMux, operands);
    return {condition.value ? a.words : b.words, ready, a.width};
}

inline const StoredWords& words_of(const StoredWords& moved) {
    return moved;
}
inline const StoredWords& words_of(const StoredWire& moved) {
    return moved.words;
}

// `ready` after a value has been converted to or from `format`; what is computed with as it is stored needs
// no converter.
inline int charge_conversion(Format format, int ready) {
    if (format == Format::kFloat32 || format == Format::kBits || format == Format::kUint32) return ready;
    return Ledger::active().charge(Unit::kConverter, ready);
}

// Which fields move together. The functional words hold values already rounded to their formats, so that
// decoding is a change of type.
class StoredFields {
 public:
    static constexpr std::size_t kMostFields = 5;

    StoredFields() = default;
    // `bits`: of all fields together in memory.
    StoredFields(std::initializer_list<Field> fields, int bits) : width_(std::max(1, (bits + 31) / 32)) {
        CHECK(fields.size() <= kMostFields, "{} fields", fields.size());
        for (const Field& f : fields) {
            fields_[count_++] = f;
            words_ += f.channels;
        }
        CHECK(words_ <= kMostStoredWords, "{} words", words_);
    }

    template <class D, class P>
    Moved<D> load(P& pixel, int element) const {
        Moved<D> moved{};
        std::size_t word = 0;
        for (std::size_t i = 0; i < count_; ++i)
            for (int c = 0; c < fields_[i].channels; ++c)
                set<D>(moved, word++, pixel.load_bits(fields_[i], element, c));
        return moved;
    }
    template <class D, class P>
    void put(P& pixel, int element, const Moved<D>& moved) const {
        std::size_t word = 0;
        for (std::size_t i = 0; i < count_; ++i)
            for (int c = 0; c < fields_[i].channels; ++c)
                pixel.put_bits(fields_[i], element, c, words_of(moved)[word++]);
    }

    // Word `word`, of a field of `format`, as a value.
    template <class D>
    static typename D::Real value(const Moved<D>& moved, std::size_t word, Format format) {
        const float value = word_value(words_of(moved)[word]);
        if constexpr (D::kCharged)
            return {value, charge_conversion(format, moved.ready)};
        else
            return value;
    }
    // The same as an integer, kept as it is.
    template <class D>
    static typename D::Uint bits(const Moved<D>& moved, std::size_t word) {
        if constexpr (D::kCharged)
            return {moved.words[word], moved.ready};
        else
            return moved[word];
    }
    template <class D>
    static Rgb<D> rgb(const Moved<D>& moved, std::size_t word, Format format) {
        return {value<D>(moved, word, format), value<D>(moved, word + 1, format),
                value<D>(moved, word + 2, format)};
    }
    // Rounds to the field's format.
    template <class D, class P>
    void set_value(Moved<D>& moved, std::size_t word, P& pixel, const Field& field,
                   const typename D::Real& value) const {
        const auto stored = pixel.as_stored(field, value);
        if constexpr (D::kCharged)
            set<D>(moved, word, {stored_word(stored.value), stored.ready});
        else
            set<D>(moved, word, stored_word(stored));
    }
    template <class D, class P>
    void set_rgb(Moved<D>& moved, std::size_t word, P& pixel, const Field& field, const Rgb<D>& rgb) const {
        const auto stored = pixel.converted(field, saturated(field, rgb));
        for (std::size_t c = 0; c < 3; ++c) {
            if constexpr (D::kCharged)
                set<D>(moved, word + c, {stored.words[c], stored.ready});
            else
                set<D>(moved, word + c, stored[c]);
        }
    }
    template <class D>
    void set(Moved<D>& moved, std::size_t word, const typename D::Uint& bits) const {
        if constexpr (D::kCharged) {
            moved.words[word] = bits.value;
            moved.ready = std::max(moved.ready, bits.ready);
            moved.width = width_;
        } else {
            moved[word] = bits;
        }
    }

 private:
    std::array<Field, kMostFields> fields_{};
    std::size_t count_ = 0;
    std::size_t words_ = 0;
    int width_ = 1;
};

// Entry `index` of the first `count`, an index that only the operation knows: a selector for each word.
template <class D, std::size_t kSize>
Moved<D> selected(const std::array<Moved<D>, kSize>& list, int count, const typename D::Uint& index) {
    Moved<D> chosen = list[value_of(index)];
    if constexpr (D::kCharged) {
        int ready = index.ready;
        for (int i = 0; i < count; ++i) ready = std::max(ready, list[static_cast<std::size_t>(i)].ready);
        for (int w = 0; w < chosen.width; ++w) chosen.ready = charge_selector(count, ready);
    }
    return chosen;
}
template <class D, std::size_t kSize>
typename D::Real selected_value(const std::array<typename D::Real, kSize>& list, int count,
                                const typename D::Uint& index) {
    if constexpr (D::kCharged) {
        int ready = index.ready;
        for (int i = 0; i < count; ++i) ready = std::max(ready, list[static_cast<std::size_t>(i)].ready);
        return {list[index.value].value, charge_selector(count, ready)};
    } else {
        return list[index];
    }
}

}  // namespace ropsim
