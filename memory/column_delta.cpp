// Columns of a block as a base and deltas of a width chosen a column.
#include "memory/column_delta.h"

#include "base/error.h"
#include "memory/column_ranges.h"

#include <bit>
#include <cstring>
#include <type_traits>

namespace ropsim {
namespace {

constexpr std::uint32_t kModeBits = 2;
// Of a width from 0 on.
template <typename T>
constexpr std::uint32_t kWidthBits = std::bit_width(kIntegerBits<T>);

template <typename T>
using Buffer = std::array<T, kColumnBuffer>;

template <typename T>
void pick(const T* values, const std::uint8_t* places, std::uint32_t count, T* out) {
    for (std::uint32_t i = 0; i < count; ++i) out[i] = values[places[i]];
}

// Of the values that begin no group, from the one before or from their group's first.
template <typename T>
void pick_differences(const T* values, const GroupIndex& index, DeltaMode mode, T* out) {
    if (mode == DeltaMode::kChain) {
        for (std::uint32_t i = 0; i < index.others; ++i)
            out[i] = static_cast<T>(values[index.other[i]] - values[index.other[i] - 1]);
    } else {
        for (std::uint32_t i = 0; i < index.others; ++i)
            out[i] = static_cast<T>(values[index.other[i]] - values[index.anchor_of_other[i]]);
    }
}

template <typename T>
void differences(const T* values, const T* from, std::uint32_t count, T* out) {
    for (std::uint32_t i = 0; i < count; ++i) out[i] = static_cast<T>(values[i] - from[i]);
}

template <typename T>
void put_offsets(BitWriter& out, const T* values, std::uint32_t count, T base, std::uint32_t width) {
    if (width == 0) return;
    Buffer<T> offsets;
    for (std::uint32_t i = 0; i < count; ++i) offsets[i] = static_cast<T>(values[i] - base);
    std::memset(offsets.data() + count, 0, 8);
    put_values(out, offsets.data(), count, width);
}

template <typename T>
void get_offsets(BitReader& in, T* values, std::uint32_t count, T base, std::uint32_t width) {
    get_values(in, values, count, width);
    for (std::uint32_t i = 0; i < count; ++i) values[i] = static_cast<T>(values[i] + base);
}

// Whether the column before holds the same elements of the same field.
bool has_previous(const BlockPlan& plan, const BlockShape& shape, std::size_t c, std::uint32_t first) {
    return c > first && plan.channels[c].follows && shape.columns[c].first == shape.columns[c - 1].first &&
           shape.columns[c].count == shape.columns[c - 1].count;
}

template <typename T>
std::uint32_t bits_of(const ColumnCode& code, std::uint32_t base_bits) {
    if (code.count == 0) return kModeBits;
    std::uint32_t bits = kModeBits + kWidthBits<T>;
    switch (code.mode) {
        case DeltaMode::kBase:
            return bits + base_bits + code.count * code.width;
        case DeltaMode::kPrevious:
            return bits + kIntegerBits<T> + code.count * code.width;
        default:
            bits += base_bits + kWidthBits<T> + kIntegerBits<T>;
            return bits + code.anchors * code.width + (code.count - code.anchors) * code.delta_width;
    }
}

template <typename T>
ColumnCode grouped_code(DeltaMode mode, Range<T> anchors, Range<T> deltas, std::uint32_t count,
                        std::uint32_t anchor_count) {
    return {mode,
            static_cast<std::uint8_t>(anchors.width),
            static_cast<std::uint8_t>(deltas.width),
            anchors.least,
            deltas.least,
            count,
            anchor_count};
}

// Of quads that begin with the column; their anchors' differences of 0 count, though not kept.
template <typename T>
ColumnCode aligned_code(const T* values, std::uint32_t count) {
    Buffer<T> anchors;
    Buffer<T> deltas;
    repeat_anchors(values, count, anchors.data());
    differences(values, anchors.data(), count, deltas.data());
    return grouped_code(DeltaMode::kAnchor, range_of(anchors.data(), count),
                        difference_range(deltas.data(), count), count, count / 4);
}

template <typename T>
ColumnCode grouped_code(const T* values, const GroupIndex& index, DeltaMode mode) {
    Buffer<T> anchors;
    Buffer<T> deltas;
    pick(values, index.anchor.data(), index.anchors, anchors.data());
    pick_differences(values, index, mode, deltas.data());
    return grouped_code(mode, range_of(anchors.data(), index.anchors),
                        difference_range(deltas.data(), index.others), index.anchors + index.others,
                        index.anchors);
}

// A column, its values and what they may refer to.
template <typename T>
struct ColumnView {
    const Column& column;
    const T* values;
    const T* previous;  // null: none
    std::uint32_t count;
    std::uint32_t base_bits;
};

template <typename T>
ColumnCode choose_column(const ColumnView<T>& view, bool aligned, unsigned modes, GroupIndexes& indexes) {
    ColumnCode best;
    best.count = view.count;
    if (view.count == 0) return best;
    const Range<T> range = range_of(view.values, view.count);
    best.width = static_cast<std::uint8_t>(range.width);
    best.base = range.least;
    if (range.width == 0) return best;
    std::uint32_t best_bits = bits_of<T>(best, view.base_bits);
    const auto consider = [&](const ColumnCode& code) {
        const std::uint32_t bits = bits_of<T>(code, view.base_bits);
        if (bits < best_bits) {
            best = code;
            best_bits = bits;
        }
    };
    if (view.previous != nullptr && (modes & mode_set(DeltaMode::kPrevious)) != 0) {
        Buffer<T> deltas;
        differences(view.values, view.previous, view.count, deltas.data());
        const Range<T> found = difference_range(deltas.data(), view.count);
        consider(
            {DeltaMode::kPrevious, static_cast<std::uint8_t>(found.width), 0, found.least, 0, view.count, 0});
    }
    for (const DeltaMode mode : {DeltaMode::kAnchor, DeltaMode::kChain}) {
        if ((modes & mode_set(mode)) == 0) continue;
        if (aligned && mode == DeltaMode::kAnchor) {
            consider(aligned_code(view.values, view.count));
            continue;
        }
        const GroupIndex& index = indexes.of(view.column);
        if (index.others != 0) consider(grouped_code(view.values, index, mode));
    }
    return best;
}

template <typename T>
void write_column(const ColumnView<T>& view, const ColumnCode& code, GroupIndexes& indexes, BitWriter& out) {
    const T base = static_cast<T>(code.base);
    if (code.mode == DeltaMode::kBase) return put_offsets(out, view.values, code.count, base, code.width);
    Buffer<T> deltas;
    if (code.mode == DeltaMode::kPrevious) {
        CHECK(view.previous != nullptr);
        differences(view.values, view.previous, code.count, deltas.data());
        return put_offsets(out, deltas.data(), code.count, base, code.width);
    }
    const GroupIndex& index = indexes.of(view.column);
    Buffer<T> anchors;
    pick(view.values, index.anchor.data(), index.anchors, anchors.data());
    pick_differences(view.values, index, code.mode, deltas.data());
    put_offsets(out, anchors.data(), index.anchors, base, code.width);
    put_offsets(out, deltas.data(), index.others, static_cast<T>(code.delta_base), code.delta_width);
}

template <typename T>
void read_column(const ColumnView<T>& view, const ColumnCode& code, GroupIndexes& indexes, BitReader& in,
                 T* values) {
    const T base = static_cast<T>(code.base);
    if (code.mode == DeltaMode::kBase || code.mode == DeltaMode::kPrevious) {
        get_offsets(in, values, code.count, base, code.width);
        if (code.mode == DeltaMode::kBase) return;
        CHECK(view.previous != nullptr);
        for (std::uint32_t i = 0; i < code.count; ++i)
            values[i] = static_cast<T>(values[i] + view.previous[i]);
        return;
    }
    const GroupIndex& index = indexes.of(view.column);
    Buffer<T> anchors;
    Buffer<T> deltas;
    get_offsets(in, anchors.data(), index.anchors, base, code.width);
    get_offsets(in, deltas.data(), index.others, static_cast<T>(code.delta_base), code.delta_width);
    for (std::uint32_t i = 0; i < index.anchors; ++i) values[index.anchor[i]] = anchors[i];
    for (std::uint32_t i = 0; i < index.others; ++i) {
        const std::uint32_t from =
            code.mode == DeltaMode::kChain ? index.other[i] - 1u : index.anchor_of_other[i];
        values[index.other[i]] = static_cast<T>(values[from] + deltas[i]);
    }
}

template <typename T>
void write_header(const ColumnCode& code, std::uint32_t base_bits, BitWriter& out) {
    if (code.count == 0) return;
    out.put(code.width, kWidthBits<T>);
    out.put(code.base, code.mode == DeltaMode::kPrevious ? kIntegerBits<T> : base_bits);
    if (code.mode == DeltaMode::kBase || code.mode == DeltaMode::kPrevious) return;
    out.put(code.delta_width, kWidthBits<T>);
    out.put(code.delta_base, kIntegerBits<T>);
}

template <typename T>
void read_header(std::uint32_t base_bits, BitReader& in, ColumnCode& code) {
    if (code.count == 0) return;
    code.width = static_cast<std::uint8_t>(in.get(kWidthBits<T>));
    const bool previous = code.mode == DeltaMode::kPrevious;
    code.base = static_cast<std::uint32_t>(in.get(previous ? kIntegerBits<T> : base_bits));
    if (code.mode == DeltaMode::kBase || previous) return;
    code.delta_width = static_cast<std::uint8_t>(in.get(kWidthBits<T>));
    code.delta_base = static_cast<std::uint32_t>(in.get(kIntegerBits<T>));
}

template <typename T>
ColumnView<T> view_of(const BlockPlan& plan, const BlockShape& shape, std::size_t c, std::uint32_t first,
                      std::uint32_t count, const BlockValues& values) {
    const T* previous =
        has_previous(plan, shape, c, first) ? values.column<T>(shape.columns[c - 1]) : nullptr;
    return {shape.columns[c], values.column<T>(shape.columns[c]), previous, count, plan.channels[c].bits};
}

// Those that a channel may have, of a codec's.
unsigned modes_of(const BlockPlan& plan, std::size_t c, unsigned modes) {
    if (group_size(plan.format) == 0)
        return modes & ~(mode_set(DeltaMode::kAnchor) | mode_set(DeltaMode::kChain));
    if ((modes & mode_set(DeltaMode::kChain)) == 0) return modes;
    return modes & ~mode_set(c < plan.first_channels ? DeltaMode::kAnchor : DeltaMode::kChain);
}

}  // namespace

void choose_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                    std::uint32_t first, unsigned modes, std::uint32_t limit, const BlockValues& values,
                    ColumnCodes& codes) {
    GroupIndexes indexes(shape, groups);
    codes.bits = 0;
    for (std::size_t c = first; c < plan.channels.size() && codes.bits <= limit; ++c) {
        const std::uint32_t count = count_used(shape, shape.columns[c], groups);
        with_integer(plan.channels[c], [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            codes.code[c] = choose_column<T>(view_of<T>(plan, shape, c, first, count, values), groups.aligned,
                                             modes_of(plan, c, modes), indexes);
            codes.bits += bits_of<T>(codes.code[c], plan.channels[c].bits);
        });
    }
}

void write_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                   std::uint32_t first, const ColumnCodes& codes, const BlockValues& values, BitWriter& out) {
    GroupIndexes indexes(shape, groups);
    const auto each = [&](auto&& visit) {
        for (std::size_t c = first; c < plan.channels.size(); ++c)
            with_integer(plan.channels[c], [&](auto* type) { visit(type, c, codes.code[c]); });
    };
    each([&](auto*, std::size_t, const ColumnCode& code) {
        out.put(static_cast<std::uint64_t>(code.mode), kModeBits);
    });
    each([&](auto* type, std::size_t c, const ColumnCode& code) {
        write_header<std::remove_pointer_t<decltype(type)>>(code, plan.channels[c].bits, out);
    });
    each([&](auto* type, std::size_t c, const ColumnCode& code) {
        using T = std::remove_pointer_t<decltype(type)>;
        write_column<T>(view_of<T>(plan, shape, c, first, code.count, values), code, indexes, out);
    });
}

void read_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                  std::uint32_t first, BitReader& in, BlockValues& values) {
    GroupIndexes indexes(shape, groups);
    std::array<ColumnCode, kMaxChannels> code;
    for (std::size_t c = first; c < plan.channels.size(); ++c)
        code[c].mode = static_cast<DeltaMode>(in.get(kModeBits));
    for (std::size_t c = first; c < plan.channels.size(); ++c) {
        code[c].count = count_used(shape, shape.columns[c], groups);
        with_integer(plan.channels[c], [&](auto* type) {
            read_header<std::remove_pointer_t<decltype(type)>>(plan.channels[c].bits, in, code[c]);
        });
    }
    for (std::size_t c = first; c < plan.channels.size(); ++c)
        with_integer(plan.channels[c], [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            read_column<T>(view_of<T>(plan, shape, c, first, code[c].count, values), code[c], indexes, in,
                           values.column<T>(shape.columns[c]));
        });
}

}  // namespace ropsim
