// Depth: planes with corrections, or references with low bits; what else an element has as columns.
#include "memory/codecs.h"
#include "memory/column_delta.h"
#include "memory/depth_planes.h"
#include "memory/depth_references.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <type_traits>

namespace ropsim {
namespace {

enum class DepthMode : std::uint8_t { kColumns, kOnePlane, kTwoPlanes, kReferences };

constexpr std::uint32_t kWidthBits = 6;  // 0..32
constexpr std::uint32_t kPixelBits = 6;  // where the second plane starts
constexpr std::uint32_t kReferenceBits = 2;
constexpr unsigned kModes = mode_set(DeltaMode::kPrevious);  // of columns

void load_depths(const BlockPlan& plan, const BlockShape& shape, const BlockValues& values,
                 DepthValues& depths) {
    place_depths(plan.format, shape.columns[0], depths);
    depths.bits = plan.channels[0].bits;
    with_integer(plan.channels[0], [&](auto* type) {
        using T = std::remove_pointer_t<decltype(type)>;
        std::copy_n(values.column<T>(shape.columns[0]), depths.count, depths.z.begin());
    });
    depths.z[depths.count] = 0;
}

void store_depths(const BlockPlan& plan, const BlockShape& shape, const DepthValues& depths,
                  BlockValues& values) {
    const auto mask = static_cast<std::uint32_t>(low_bits(depths.bits));
    with_integer(plan.channels[0], [&](auto* type) {
        using T = std::remove_pointer_t<decltype(type)>;
        T* column = values.column<T>(shape.columns[0]);
        for (std::uint32_t i = 0; i < depths.count; ++i) column[i] = static_cast<T>(depths.z[i] & mask);
    });
}

std::uint32_t plane_bits(const DepthValues& depths, const PlaneFit& fit, std::uint32_t planes) {
    return kWidthBits + planes * (depths.bits + 2 * slope_bits(depths.bits)) + (planes - 1) * kPixelBits +
           depths.count * (fit.width + planes - 1);
}

void write_planes(const DepthValues& depths, const PlaneFit& fit, std::uint32_t planes, BitWriter& out) {
    out.put(fit.width, kWidthBits);
    const std::uint32_t slope = slope_bits(depths.bits);
    for (std::uint32_t p = 0; p < planes; ++p) {
        const DepthPlane& plane = fit.plane[p];
        out.put(plane.z0 & low_bits(depths.bits), depths.bits);
        out.put(static_cast<std::uint64_t>(plane.dx) & low_bits(slope), slope);
        out.put(static_cast<std::uint64_t>(plane.dy) & low_bits(slope), slope);
        if (p == 1) out.put(static_cast<std::uint64_t>(plane.y0 * 8 + plane.x0), kPixelBits);
    }
    std::array<std::uint8_t, kMaxBlockBytes + 8> second;
    std::array<std::uint32_t, kMaxBlockBytes + 2> corrections;
    const std::array<PlaneDepths, 2> on{PlaneDepths(fit.plane[0]), PlaneDepths(fit.plane[planes - 1])};
    for (std::uint32_t i = 0; i < depths.count; ++i) {
        second[i] = planes == 2 ? fit.second[i] : 0;
        corrections[i] = depths.z[i] - on[second[i]].at(depths.x[i], depths.y[i]);
    }
    std::memset(second.data() + depths.count, 0, 8);
    corrections[depths.count] = 0;
    if (planes == 2) put_values(out, second.data(), depths.count, 1);
    put_values(out, corrections.data(), depths.count, fit.width);
}

std::int64_t get_slope(BitReader& in, std::uint32_t bits) {
    const std::uint64_t sign = std::uint64_t{1} << (bits - 1);
    return static_cast<std::int64_t>((in.get(bits) ^ sign) - sign);
}

void read_planes(std::uint32_t planes, BitReader& in, DepthValues& depths) {
    PlaneFit fit;
    fit.width = static_cast<std::uint32_t>(in.get(kWidthBits));
    const std::uint32_t slope = slope_bits(depths.bits);
    for (std::uint32_t p = 0; p < planes; ++p) {
        DepthPlane& plane = fit.plane[p];
        plane.z0 = static_cast<std::uint32_t>(in.get(depths.bits));
        plane.dx = get_slope(in, slope);
        plane.dy = get_slope(in, slope);
        const auto pixel = p == 0 ? 0 : static_cast<std::int32_t>(in.get(kPixelBits));
        plane.x0 = p == 0 && depths.count != 0 ? depths.x[0] : pixel % 8;
        plane.y0 = p == 0 && depths.count != 0 ? depths.y[0] : pixel / 8;
    }
    std::array<std::uint8_t, kMaxBlockBytes + 8> second;
    get_values(in, second.data(), depths.count, planes - 1);
    get_values(in, depths.z.data(), depths.count, fit.width);
    const std::array<PlaneDepths, 2> on{PlaneDepths(fit.plane[0]), PlaneDepths(fit.plane[planes - 1])};
    for (std::uint32_t i = 0; i < depths.count; ++i)
        depths.z[i] += on[second[i]].at(depths.x[i], depths.y[i]);
}

// The low bits that references have at this level behind `fixed` bits, or -1 if the depths do not fit.
int fitting_low_bits(const DepthValues& depths, std::uint32_t fixed, std::uint32_t level) {
    if (fixed > level * 8) return -1;
    const int low = reference_low_bits(level * 8 - fixed, depths.count, depths.bits);
    if (low < 0 || depths.count == 0) return low;
    const auto [least, largest] = std::minmax_element(depths.z.begin(), depths.z.begin() + depths.count);
    const DepthReferences references(*least >> low, *largest >> low, static_cast<std::uint32_t>(low));
    for (std::uint32_t i = 0; i < depths.count; ++i)
        if (references.index(depths.z[i]) == 4) return -1;
    return low;
}

void write_references(const DepthValues& depths, std::uint32_t low, BitWriter& out) {
    if (depths.count == 0) return;
    const auto [least, largest] = std::minmax_element(depths.z.begin(), depths.z.begin() + depths.count);
    const DepthReferences references(*least >> low, *largest >> low, low);
    out.put(references.high[0], depths.bits - low);
    out.put(references.high[1], depths.bits - low);
    for (std::uint32_t i = 0; i < depths.count; ++i) {
        out.put(references.index(depths.z[i]), kReferenceBits);
        out.put(depths.z[i] & low_bits(low), low);
    }
}

void read_references(std::uint32_t low, BitReader& in, DepthValues& depths) {
    if (depths.count == 0) return;
    const auto least = static_cast<std::uint32_t>(in.get(depths.bits - low));
    const auto largest = static_cast<std::uint32_t>(in.get(depths.bits - low));
    const DepthReferences references(least, largest, low);
    for (std::uint32_t i = 0; i < depths.count; ++i) {
        const auto index = static_cast<std::size_t>(in.get(kReferenceBits));
        depths.z[i] = references.high[index] << low | static_cast<std::uint32_t>(in.get(low));
    }
}

// What is chosen for a block.
struct DepthChoice {
    DepthMode mode = DepthMode::kColumns;
    std::uint32_t level = 0;
    PlaneFit fit;
    std::uint32_t low = 0;
};

void choose_planes(const BlockPlan& plan, const DepthValues& depths, std::uint32_t fixed,
                   DepthChoice& choice) {
    for (const std::uint32_t planes : {1u, 2u}) {
        if (choice.level == plan.levels.front()) return;
        const PlaneFit fit = planes == 1 ? fit_one_plane(depths) : fit_two_planes(depths);
        const std::uint32_t level = plan.level_of(fixed + plane_bits(depths, fit, planes));
        if (level >= choice.level) continue;
        choice.mode = planes == 1 ? DepthMode::kOnePlane : DepthMode::kTwoPlanes;
        choice.level = level;
        choice.fit = fit;
    }
}

void choose_references(const BlockPlan& plan, const DepthValues& depths, std::uint32_t fixed,
                       DepthChoice& choice) {
    for (const std::uint32_t level : plan.levels) {
        if (level >= choice.level) return;
        const int low = fitting_low_bits(depths, fixed, level);
        if (low < 0) continue;
        choice.mode = DepthMode::kReferences;
        choice.level = level;
        choice.low = static_cast<std::uint32_t>(low);
    }
}

}  // namespace

std::uint32_t compress_depth(const BlockPlan& plan, DepthCoding coding, const std::uint8_t* block,
                             std::uint32_t tile_offset, std::uint8_t* out) {
    const std::uint32_t block_bytes = plan.format.block_bytes;
    if (plan.levels.empty()) return block_bytes;
    const BlockShape shape = plan.shape(tile_offset);
    BlockValues values;
    if (!plan.gather(block, shape, values)) return block_bytes;
    ElementGroups groups;
    group_elements(plan, shape, groups);
    const std::uint32_t limit = plan.levels.back() * 8;
    std::uint32_t fixed = kBlockModeBits + shape.head_bits + shape.tail_bits;
    ColumnCodes codes;
    choose_columns(plan, shape, groups, 0, kModes, limit, values, codes);
    DepthChoice choice;
    choice.level = plan.level_of(fixed + codes.bits);
    if (choice.level != plan.levels.front() && plan.depth_first) {
        ColumnCodes others;
        choose_columns(plan, shape, groups, 1, kModes, limit, values, others);
        fixed += others.bits;
        DepthValues depths;
        load_depths(plan, shape, values, depths);
        if (coding.planes) choose_planes(plan, depths, fixed, choice);
        if (coding.references) choose_references(plan, depths, fixed, choice);
        if (choice.mode != DepthMode::kColumns) {
            BitWriter writer;
            writer.put(static_cast<std::uint64_t>(choice.mode), kBlockModeBits);
            write_straddling(shape, block, writer);
            write_columns(plan, shape, groups, 1, others, values, writer);
            if (choice.mode == DepthMode::kReferences)
                write_references(depths, choice.low, writer);
            else
                write_planes(depths, choice.fit, choice.mode == DepthMode::kTwoPlanes ? 2 : 1, writer);
            writer.copy(out, choice.level);
            return choice.level;
        }
    }
    if (choice.level == block_bytes) return block_bytes;
    BitWriter writer;
    writer.put(static_cast<std::uint64_t>(DepthMode::kColumns), kBlockModeBits);
    write_straddling(shape, block, writer);
    write_columns(plan, shape, groups, 0, codes, values, writer);
    writer.copy(out, choice.level);
    return choice.level;
}

void decompress_depth(const BlockPlan& plan, const std::uint8_t* in, std::uint32_t bytes,
                      std::uint32_t tile_offset, std::uint8_t* block) {
    const BlockShape shape = plan.shape(tile_offset);
    ElementGroups groups;
    group_elements(plan, shape, groups);
    BitReader reader(in, bytes);
    const auto mode = static_cast<DepthMode>(reader.get(kBlockModeBits));
    read_straddling(shape, reader, block);
    BlockValues values;
    read_columns(plan, shape, groups, mode == DepthMode::kColumns ? 0 : 1, reader, values);
    if (mode != DepthMode::kColumns) {
        DepthValues depths;
        place_depths(plan.format, shape.columns[0], depths);
        depths.bits = plan.channels[0].bits;
        if (mode == DepthMode::kReferences) {
            const std::uint32_t room = bytes * 8 - reader.position();
            read_references(static_cast<std::uint32_t>(reference_low_bits(room, depths.count, depths.bits)),
                            reader, depths);
        } else {
            read_planes(mode == DepthMode::kTwoPlanes ? 2 : 1, reader, depths);
        }
        store_depths(plan, shape, depths, values);
    }
    plan.scatter(shape, values, block);
}

}  // namespace ropsim
