// Which elements of a block take part in its columns, and which of them belong together.
#include "memory/column_groups.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace ropsim {
namespace {

const std::uint8_t* used_of(const BlockShape& shape, const Column& column, const ElementGroups& groups) {
    return groups.used.data() + (column.first - shape.first_element);
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

std::uint32_t count_used(const BlockShape& shape, const Column& column, const ElementGroups& groups) {
    if (groups.all_used) return column.count;
    const std::uint8_t* used = used_of(shape, column, groups);
    return static_cast<std::uint32_t>(std::count(used, used + column.count, 1));
}

void compact_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                     BlockValues& values) {
    for (std::size_t c = 0; c < plan.channels.size(); ++c) {
        const Column& column = shape.columns[c];
        const std::uint8_t* used = used_of(shape, column, groups);
        with_integer(plan.channels[c], [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            T* v = values.column<T>(column);
            const std::uint32_t count = column.count;
            for (std::uint32_t i = 0, kept = 0; i < count; ++i) {
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
        const std::uint8_t* used = used_of(shape, column, groups);
        with_integer(plan.channels[c], [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            T* v = values.column<T>(column);
            const auto clear = static_cast<T>(plan.clear_values[c]);
            std::uint32_t kept = count_used(shape, column, groups);
            for (std::uint32_t i = column.count; i-- > 0;) v[i] = used[i] != 0 ? v[--kept] : clear;
        });
    }
}

const GroupIndex& GroupIndexes::of(const Column& column) {
    if (column.first == first_ && column.count == count_) return index_;
    first_ = column.first;
    count_ = column.count;
    std::uint32_t anchors = 0;
    std::uint32_t others = 0;
    const auto add = [&](std::uint32_t place, bool starts) {
        // The entry that is not meant is overwritten by the next.
        index_.anchor[anchors] = static_cast<std::uint8_t>(place);
        anchors += starts;
        index_.other[others] = static_cast<std::uint8_t>(place);
        index_.anchor_of_other[others] = index_.anchor[anchors - 1];
        others += !starts;
    };
    if (groups_.aligned) {
        for (std::uint32_t i = 0; i < column.count; ++i) add(i, i % 4 == 0);
    } else {
        const std::uint32_t begin = column.first - shape_.first_element;
        int last = -1;
        for (std::uint32_t e = begin, place = 0; e < begin + column.count; ++e) {
            if (groups_.used[e] == 0) continue;
            add(place++, groups_.group[e] != last);
            last = groups_.group[e];
        }
    }
    index_.anchors = anchors;
    index_.others = others;
    return index_;
}

}  // namespace ropsim
