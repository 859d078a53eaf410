// Columns of a block as a base and deltas of a width chosen a column.
#include "memory/column_delta.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>

namespace ropsim {
namespace {

constexpr std::uint32_t kModeBits = 2;
constexpr std::uint32_t kBuffer = kMaxBlockBytes + 16;  // values; whole words may be moved at the end

template <typename T>
constexpr std::uint32_t kBits = sizeof(T) * 8;
// Of a width 0..kBits.
template <typename T>
constexpr std::uint32_t kWidthBits = std::bit_width(kBits<T>);

// One a value of a column: whether its group begins with it.
struct Starts {
    std::array<std::uint8_t, kBuffer> is_start;
    std::uint32_t count = 0;
    std::uint32_t anchors = 0;

    Starts(const BlockShape& shape, const Column& column, const ElementGroups& groups) {
        if (groups.aligned) {
            count = column.count;
            anchors = count / 4;
            for (std::uint32_t i = 0; i < count; ++i) is_start[i] = i % 4 == 0;
            return;
        }
        int last = -1;
        const std::uint32_t begin = column.first - shape.first_element;
        for (std::uint32_t e = begin; e < begin + column.count; ++e) {
            if (groups.used[e] == 0) continue;
            const bool start = groups.group[e] != last;
            last = groups.group[e];
            is_start[count++] = start;
            anchors += start;
        }
    }
};

template <typename T>
struct Range {
    T least;
    std::uint32_t width;  // bits of the largest difference from it
};

// The integer whose least and largest the compiler finds in vectors of every x86-64: unsigned bytes, signed
// else. Flipping the top bit turns one order into the other.
template <typename T>
using Sought = std::conditional_t<sizeof(T) == 1, std::uint8_t, std::make_signed_t<T>>;
template <typename T>
constexpr T kTop = static_cast<T>(T{1} << (kBits<T> - 1));

template <typename T, T kFlip>
Range<T> flipped_range(const T* values, std::uint32_t count) {
    auto least = static_cast<Sought<T>>(values[0] ^ kFlip);
    auto largest = least;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto value = static_cast<Sought<T>>(values[i] ^ kFlip);
        least = value < least ? value : least;
        largest = value > largest ? value : largest;
    }
    const T span = static_cast<T>(static_cast<T>(largest) - static_cast<T>(least));
    return {static_cast<T>(static_cast<T>(least) ^ kFlip), static_cast<std::uint32_t>(std::bit_width(span))};
}

template <typename T>
Range<T> range_of(const T* values, std::uint32_t count) {
    constexpr T kFlip = sizeof(T) == 1 ? 0 : kTop<T>;
    return flipped_range<T, kFlip>(values, count);
}

// The same of differences, which are signed.
template <typename T>
Range<T> difference_range(const T* values, std::uint32_t count) {
    constexpr T kFlip = sizeof(T) == 1 ? kTop<T> : 0;
    return flipped_range<T, kFlip>(values, count);
}

// Anchors and differences of a column, apart.
template <typename T>
struct Split {
    std::array<T, kBuffer> anchors;
    std::array<T, kBuffer> deltas;
    std::uint32_t anchor_count = 0;
    std::uint32_t delta_count = 0;

    void aligned(const T* values, std::uint32_t count) {
        anchor_count = count / 4;
        delta_count = count / 4 * 3;
        for (std::uint32_t g = 0; g < anchor_count; ++g) {
            const T anchor = values[4 * g];
            anchors[g] = anchor;
            for (std::uint32_t k = 0; k < 3; ++k)
                deltas[3 * g + k] = static_cast<T>(values[4 * g + 1 + k] - anchor);
        }
    }
    void scattered(const T* values, const Starts& starts, bool chain) {
        T reference = 0;
        for (std::uint32_t i = 0; i < starts.count; ++i) {
            const T value = values[i];
            anchors[anchor_count] = value;
            deltas[delta_count] = static_cast<T>(value - reference);
            const bool start = starts.is_start[i] != 0;
            anchor_count += start;
            delta_count += !start;
            reference = start || chain ? value : reference;
        }
    }
};

template <typename T>
void put_offsets(BitWriter& out, const T* values, std::uint32_t count, T base, std::uint32_t width) {
    if (width == 0) return;
    std::array<T, kBuffer> offsets;
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
            return bits + kBits<T> + code.count * code.width;
        default:
            bits += base_bits + kWidthBits<T> + kBits<T>;
            return bits + code.anchors * code.width + (code.count - code.anchors) * code.delta_width;
    }
}

template <typename T>
ColumnCode grouped_code(DeltaMode mode, const Split<T>& split) {
    const Range<T> anchors = range_of(split.anchors.data(), split.anchor_count);
    const Range<T> deltas = difference_range(split.deltas.data(), split.delta_count);
    return {mode,
            static_cast<std::uint8_t>(anchors.width),
            static_cast<std::uint8_t>(deltas.width),
            anchors.least,
            deltas.least,
            split.anchor_count + split.delta_count,
            split.anchor_count};
}

// Sixteen bytes, that the compiler keeps in a register.
using Words16 = std::uint32_t __attribute__((vector_size(16)));
using LongWords16 = std::uint64_t __attribute__((vector_size(16)));

// The first of every four values, four times; reads and writes to the next multiple of 16 bytes.
template <typename T>
void repeat_anchors(const T* values, std::uint32_t count, T* out) {
    for (std::uint32_t i = 0; i < count; i += 16 / sizeof(T)) {
        std::conditional_t<sizeof(T) == 2, LongWords16, Words16> words;
        std::memcpy(&words, values + i, 16);
        if constexpr (sizeof(T) == 4) {
            words = __builtin_shuffle(words, Words16{0, 0, 0, 0});
        } else {
            words &= static_cast<T>(~T{0});
            words |= words << kBits<T>;
            words |= words << 2 * kBits<T>;
        }
        std::memcpy(out + i, &words, 16);
    }
}

// Of quads that begin with the column; their anchors' differences of 0 count, though not kept.
template <typename T>
ColumnCode aligned_code(const T* values, std::uint32_t count) {
    std::array<T, kBuffer> anchors;
    std::array<T, kBuffer> deltas;
    repeat_anchors(values, count, anchors.data());
    for (std::uint32_t i = 0; i < count; ++i) deltas[i] = static_cast<T>(values[i] - anchors[i]);
    const Range<T> anchor = range_of(anchors.data(), count);
    const Range<T> delta = difference_range(deltas.data(), count);
    return {DeltaMode::kAnchor,
            static_cast<std::uint8_t>(anchor.width),
            static_cast<std::uint8_t>(delta.width),
            anchor.least,
            delta.least,
            count,
            count / 4};
}

template <typename T>
ColumnCode choose_column(const BlockShape& shape, const Column& column, const ElementGroups& groups,
                         std::uint32_t base_bits, unsigned modes, const T* values, const T* previous,
                         std::uint32_t count) {
    ColumnCode best;
    best.count = count;
    if (count == 0) return best;
    const Range<T> range = range_of(values, count);
    best.width = static_cast<std::uint8_t>(range.width);
    best.base = range.least;
    if (range.width == 0) return best;
    const auto consider = [&](const ColumnCode& code) {
        if (bits_of<T>(code, base_bits) < bits_of<T>(best, base_bits)) best = code;
    };
    if (previous != nullptr && (modes & mode_set(DeltaMode::kPrevious)) != 0) {
        std::array<T, kBuffer> deltas;
        for (std::uint32_t i = 0; i < count; ++i) deltas[i] = static_cast<T>(values[i] - previous[i]);
        const Range<T> found = difference_range(deltas.data(), count);
        consider({DeltaMode::kPrevious, static_cast<std::uint8_t>(found.width), 0, found.least, 0, count, 0});
    }
    if ((modes & (mode_set(DeltaMode::kAnchor) | mode_set(DeltaMode::kChain))) == 0) return best;
    if (groups.aligned) {
        consider(aligned_code(values, count));
        return best;
    }
    const Starts starts(shape, column, groups);
    if (starts.anchors == starts.count) return best;
    for (const DeltaMode mode : {DeltaMode::kAnchor, DeltaMode::kChain}) {
        if ((modes & mode_set(mode)) == 0) continue;
        Split<T> split;
        split.scattered(values, starts, mode == DeltaMode::kChain);
        consider(grouped_code(mode, split));
    }
    return best;
}

template <typename T>
void write_column(const BlockShape& shape, const Column& column, const ElementGroups& groups,
                  const ColumnCode& code, const T* values, const T* previous, BitWriter& out) {
    const T base = static_cast<T>(code.base);
    if (code.mode == DeltaMode::kBase) return put_offsets(out, values, code.count, base, code.width);
    if (code.mode == DeltaMode::kPrevious) {
        std::array<T, kBuffer> deltas;
        for (std::uint32_t i = 0; i < code.count; ++i) deltas[i] = static_cast<T>(values[i] - previous[i]);
        return put_offsets(out, deltas.data(), code.count, base, code.width);
    }
    Split<T> split;
    if (groups.aligned)
        split.aligned(values, code.count);
    else
        split.scattered(values, Starts(shape, column, groups), code.mode == DeltaMode::kChain);
    put_offsets(out, split.anchors.data(), split.anchor_count, base, code.width);
    put_offsets(out, split.deltas.data(), split.delta_count, static_cast<T>(code.delta_base),
                code.delta_width);
}

template <typename T>
void read_column(const BlockShape& shape, const Column& column, const ElementGroups& groups,
                 const ColumnCode& code, const T* previous, BitReader& in, T* values) {
    const T base = static_cast<T>(code.base);
    if (code.mode == DeltaMode::kBase || code.mode == DeltaMode::kPrevious) {
        get_offsets(in, values, code.count, base, code.width);
        if (code.mode == DeltaMode::kBase) return;
        for (std::uint32_t i = 0; i < code.count; ++i) values[i] = static_cast<T>(values[i] + previous[i]);
        return;
    }
    const Starts starts(shape, column, groups);
    std::array<T, kBuffer> anchors;
    std::array<T, kBuffer> deltas;
    get_offsets(in, anchors.data(), starts.anchors, base, code.width);
    get_offsets(in, deltas.data(), starts.count - starts.anchors, static_cast<T>(code.delta_base),
                code.delta_width);
    T reference = 0;
    for (std::uint32_t i = 0, a = 0, d = 0; i < starts.count; ++i) {
        const bool start = starts.is_start[i] != 0;
        values[i] = start ? anchors[a++] : static_cast<T>(reference + deltas[d++]);
        if (start || code.mode == DeltaMode::kChain) reference = values[i];
    }
}

template <typename T>
void write_header(const ColumnCode& code, std::uint32_t base_bits, BitWriter& out) {
    if (code.count == 0) return;
    out.put(code.width, kWidthBits<T>);
    out.put(code.base, code.mode == DeltaMode::kPrevious ? kBits<T> : base_bits);
    if (code.mode == DeltaMode::kBase || code.mode == DeltaMode::kPrevious) return;
    out.put(code.delta_width, kWidthBits<T>);
    out.put(code.delta_base, kBits<T>);
}

template <typename T>
void read_header(std::uint32_t base_bits, BitReader& in, ColumnCode& code) {
    if (code.count == 0) return;
    code.width = static_cast<std::uint8_t>(in.get(kWidthBits<T>));
    const bool previous = code.mode == DeltaMode::kPrevious;
    code.base = static_cast<std::uint32_t>(in.get(previous ? kBits<T> : base_bits));
    if (code.mode == DeltaMode::kBase || previous) return;
    code.delta_width = static_cast<std::uint8_t>(in.get(kWidthBits<T>));
    code.delta_base = static_cast<std::uint32_t>(in.get(kBits<T>));
}

std::uint32_t count_used(const BlockShape& shape, const Column& column, const ElementGroups& groups) {
    if (groups.all_used) return column.count;
    const std::uint8_t* used = groups.used.data() + (column.first - shape.first_element);
    return static_cast<std::uint32_t>(std::count(used, used + column.count, 1));
}

std::uint32_t group_size(const BlockFormat& format) {
    return format.planar || format.elements == 1 ? 4 : format.elements;
}

}  // namespace

void group_elements(const BlockPlan& plan, const BlockShape& shape, ElementGroups& groups, bool masked) {
    groups.all_used = true;
    groups.aligned = false;
    const std::uint32_t size = group_size(plan.format);
    if (size == 4 && !masked) {
        groups.aligned = true;
        for (std::size_t c = 0; c < plan.channels.size(); ++c)
            if ((shape.columns[c].first | shape.columns[c].count) % 4 != 0) groups.aligned = false;
        if (groups.aligned) return;
    }
    const std::uint32_t count = shape.end_element - shape.first_element;
    std::memset(groups.used.data(), 1, count);
    std::uint32_t place = size == 0 ? 0 : shape.first_element % size;
    std::uint8_t group = 0;
    for (std::uint32_t e = 0; e < count; ++e) {
        groups.group[e] = group;
        if (++place == size) {
            place = 0;
            ++group;
        }
    }
}

unsigned possible_modes(const BlockPlan& plan, unsigned modes) {
    if (plan.format.elements != 0) return modes;
    return modes & ~(mode_set(DeltaMode::kAnchor) | mode_set(DeltaMode::kChain));
}

void compact_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                     BlockValues& values) {
    for (std::size_t c = 0; c < plan.channels.size(); ++c) {
        const Column& column = shape.columns[c];
        const std::uint8_t* used = groups.used.data() + (column.first - shape.first_element);
        with_integer(plan.channels[c], [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            T* v = values.column<T>(column);
            for (std::uint32_t i = 0, kept = 0; i < column.count; ++i) {
                v[kept] = v[i];
                kept += used[i];
            }
        });
    }
}

void expand_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                    BlockValues& values) {
    for (std::size_t c = 0; c < plan.channels.size(); ++c) {
        const Column& column = shape.columns[c];
        const std::uint8_t* used = groups.used.data() + (column.first - shape.first_element);
        with_integer(plan.channels[c], [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            T* v = values.column<T>(column);
            std::uint32_t kept = count_used(shape, column, groups);
            for (std::uint32_t i = column.count; i-- > 0;)
                v[i] = used[i] != 0 ? v[--kept] : static_cast<T>(plan.clear_values[c]);
        });
    }
}

void choose_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                    std::uint32_t first, unsigned modes, std::uint32_t limit, const BlockValues& values,
                    ColumnCodes& codes) {
    codes.bits = 0;
    for (std::size_t c = first; c < plan.channels.size() && codes.bits <= limit; ++c) {
        const Column& column = shape.columns[c];
        const std::uint32_t base_bits = plan.channels[c].bits;
        with_integer(plan.channels[c], [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            const T* previous =
                has_previous(plan, shape, c, first) ? values.column<T>(shape.columns[c - 1]) : nullptr;
            codes.code[c] =
                choose_column<T>(shape, column, groups, base_bits, modes, values.column<T>(column), previous,
                                 count_used(shape, column, groups));
            codes.bits += bits_of<T>(codes.code[c], base_bits);
        });
    }
}

void write_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                   std::uint32_t first, const ColumnCodes& codes, const BlockValues& values, BitWriter& out) {
    for (std::size_t c = first; c < plan.channels.size(); ++c)
        out.put(static_cast<std::uint64_t>(codes.code[c].mode), kModeBits);
    for (std::size_t c = first; c < plan.channels.size(); ++c)
        with_integer(plan.channels[c], [&](auto* type) {
            write_header<std::remove_pointer_t<decltype(type)>>(codes.code[c], plan.channels[c].bits, out);
        });
    for (std::size_t c = first; c < plan.channels.size(); ++c)
        with_integer(plan.channels[c], [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            const T* previous = c > first ? values.column<T>(shape.columns[c - 1]) : nullptr;
            write_column<T>(shape, shape.columns[c], groups, codes.code[c],
                            values.column<T>(shape.columns[c]), previous, out);
        });
}

void read_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                  std::uint32_t first, BitReader& in, BlockValues& values) {
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
            const T* previous = c > first ? values.column<T>(shape.columns[c - 1]) : nullptr;
            read_column<T>(shape, shape.columns[c], groups, code[c], previous, in,
                           values.column<T>(shape.columns[c]));
        });
}

}  // namespace ropsim
