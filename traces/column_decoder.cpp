// Decodes a column of a trace block: unpacks each byte plane, then undoes the filter.
#include "traces/column_codec.h"
#include "traces/column_filters.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include <zstd.h>

namespace ropsim {

struct ColumnDecoder::State {
    ZSTD_DCtx* zstd = ZSTD_createDCtx();
    std::vector<std::uint8_t> planes;

    ~State() { ZSTD_freeDCtx(zstd); }

    // The bytes of one plane: in place where it is stored raw, else decoded into `scratch` (count bytes).
    const std::uint8_t* take_plane(ByteCursor& in, std::size_t count, std::uint8_t* scratch) {
        switch (static_cast<PlaneMethod>(in.byte())) {
            case PlaneMethod::kConstant:
                std::memset(scratch, in.byte(), count);
                return scratch;
            case PlaneMethod::kRaw:
                return in.take(count);
            case PlaneMethod::kZstd: {
                const std::uint64_t size = in.varint();
                const std::uint8_t* frame = in.take(size);
                if (ZSTD_decompressDCtx(zstd, scratch, count, frame, size) != count)
                    throw FormatFault("a compressed plane does not decode");
                return scratch;
            }
        }
        throw FormatFault("unknown plane method");
    }

    void take_planes(ByteCursor& in, std::size_t count, std::uint8_t* elements) {
        const std::uint8_t* p = take_plane(in, count, elements);
        if (p != elements) std::memcpy(elements, p, count);
    }
    void take_planes(ByteCursor& in, std::size_t count, std::uint16_t* elements) {
        planes.resize(2 * count);
        const std::uint8_t* p0 = take_plane(in, count, planes.data());
        const std::uint8_t* p1 = take_plane(in, count, planes.data() + count);
        for (std::size_t i = 0; i < count; ++i) elements[i] = static_cast<std::uint16_t>(p0[i] | p1[i] << 8);
    }
    void take_planes(ByteCursor& in, std::size_t count, std::uint32_t* elements) {
        planes.resize(4 * count);
        std::array<const std::uint8_t*, 4> p{};
        for (std::size_t k = 0; k < 4; ++k) p[k] = take_plane(in, count, planes.data() + k * count);
        for (std::size_t i = 0; i < count; ++i)
            elements[i] = static_cast<std::uint32_t>(p[0][i]) | static_cast<std::uint32_t>(p[1][i]) << 8 |
                          static_cast<std::uint32_t>(p[2][i]) << 16 |
                          static_cast<std::uint32_t>(p[3][i]) << 24;
    }

    template <typename T>
    void take_palette(ByteCursor& in, std::size_t count, T* elements) {
        const std::size_t size = in.byte() + std::size_t{1};
        std::array<T, kMaxPalette> palette{};
        std::memcpy(palette.data(), in.take(size * sizeof(T)), size * sizeof(T));
        planes.resize(count);
        const std::uint8_t* indices = take_plane(in, count, planes.data());
        std::uint8_t largest = 0;
        for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, indices[i]);
        if (largest >= size) throw FormatFault("an index lies beyond the palette");
        for (std::size_t i = 0; i < count; ++i) elements[i] = palette[indices[i]];
    }
};

ColumnDecoder::ColumnDecoder() : state_(std::make_unique<State>()) {}
ColumnDecoder::~ColumnDecoder() = default;

template <typename T>
void ColumnDecoder::decode(ByteCursor in, std::size_t count, T* elements) {
    const auto filter = static_cast<ColumnFilter>(in.byte());
    switch (filter) {
        case ColumnFilter::kConstant:
            std::fill_n(elements, count, in.record<T>());
            break;
        case ColumnFilter::kPalette:
            state_->take_palette(in, count, elements);
            break;
        case ColumnFilter::kNone:
        case ColumnFilter::kIncrement:
        case ColumnFilter::kDelta1:
        case ColumnFilter::kDelta4:
            state_->take_planes(in, count, elements);
            undo_filter(filter, elements, count);
            break;
        default:
            throw FormatFault("unknown filter");
    }
    if (in.left() != 0) throw FormatFault("is longer than its data");
}

template void ColumnDecoder::decode(ByteCursor, std::size_t, std::uint8_t*);
template void ColumnDecoder::decode(ByteCursor, std::size_t, std::uint16_t*);
template void ColumnDecoder::decode(ByteCursor, std::size_t, std::uint32_t*);

}  // namespace ropsim
