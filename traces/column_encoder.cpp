// Compresses a column of a trace block: chooses its filter, then packs each byte plane on its own.
#include "base/error.h"
#include "traces/column_codec.h"
#include "traces/column_filters.h"
#include "traces/exact_log2.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include <zstd.h>

namespace ropsim {

namespace {

constexpr int kZstdLevel = 1;
constexpr std::size_t kSampleElements = 1024;  // the choice of a filter looks at this many elements
// Planes with more than this many bits a byte are stored as they are: decoding them is then a copy.
constexpr float kRawEntropy = 7.8f;

using Histogram = std::array<std::uint32_t, 256>;

// log2(n) from the ten leading bits of n >= 1.
float approximate_log2(std::uint32_t n) {
    static const auto table = [] {
        std::array<float, 1024> values{};
        for (std::uint32_t i = 1; i < values.size(); ++i) values[i] = exact_log2(i);
        return values;
    }();
    const int shift = std::max(0, static_cast<int>(std::bit_width(n)) - 10);
    return table[n >> shift] + static_cast<float>(shift);
}

// n * log2(n) for counts of a sample.
const std::array<float, kSampleElements + 1>& n_log_n() {
    static const auto table = [] {
        std::array<float, kSampleElements + 1> values{};
        for (std::uint32_t n = 1; n < values.size(); ++n) values[n] = static_cast<float>(n) * exact_log2(n);
        return values;
    }();
    return table;
}

// Bits that an ideal order-0 coder needs for the byte planes of `count` (<= kSampleElements) elements.
template <typename T>
float sample_bits(const T* elements, std::size_t count) {
    const auto& weight = n_log_n();
    float bits = 0;
    for (std::size_t plane = 0; plane < sizeof(T); ++plane) {
        std::array<std::uint16_t, 256> histogram{};
        for (std::size_t i = 0; i < count; ++i)
            ++histogram[static_cast<std::uint8_t>(elements[i] >> (8 * plane))];
        float sum = 0;
        for (const std::uint16_t n : histogram) sum += weight[n];
        bits += weight[count] - sum;
    }
    return bits;
}

float entropy_per_byte(const Histogram& histogram, std::size_t count) {
    float sum = 0;
    for (const std::uint32_t n : histogram)
        if (n) sum += static_cast<float>(n) * approximate_log2(n);
    return approximate_log2(static_cast<std::uint32_t>(count)) - sum / static_cast<float>(count);
}

// The distinct values of a column in order of appearance, and each element's index; false beyond 256 of them.
template <typename T>
bool build_palette(const T* elements, std::size_t count, std::vector<T>& palette, std::uint8_t* indices) {
    constexpr std::size_t kSlots = 1024;
    std::array<std::int16_t, kSlots> slots;
    slots.fill(-1);
    palette.clear();
    for (std::size_t i = 0; i < count; ++i) {
        std::size_t slot = (static_cast<std::uint32_t>(elements[i]) * 0x9E3779B1u) >> 22;
        while (slots[slot] >= 0 && palette[static_cast<std::size_t>(slots[slot])] != elements[i])
            slot = (slot + 1) % kSlots;
        if (slots[slot] < 0) {
            if (palette.size() == kMaxPalette) return false;
            slots[slot] = static_cast<std::int16_t>(palette.size());
            palette.push_back(elements[i]);
        }
        indices[i] = static_cast<std::uint8_t>(slots[slot]);
    }
    return true;
}

}  // namespace

struct ColumnEncoder::State {
    ZSTD_CCtx* zstd = ZSTD_createCCtx();
    std::vector<std::uint8_t> filtered;  // storage for elements of any width
    std::vector<std::uint8_t> plane;
    std::vector<std::uint8_t> indices;

    ~State() { ZSTD_freeCCtx(zstd); }

    void put_plane(const std::uint8_t* bytes, std::size_t count, Bytes& out) {
        Histogram histogram{};
        for (std::size_t i = 0; i < count; ++i) ++histogram[bytes[i]];
        if (histogram[bytes[0]] == count) {
            out.push_back(static_cast<std::uint8_t>(PlaneMethod::kConstant));
            out.push_back(bytes[0]);
            return;
        }
        if (entropy_per_byte(histogram, count) < kRawEntropy) {
            const std::size_t start = out.size();
            out.push_back(static_cast<std::uint8_t>(PlaneMethod::kZstd));
            // The size comes first but is known last: it gets the room of the worst case, then the frame
            // moves up.
            constexpr std::size_t kRoom = 5;
            const std::size_t bound = ZSTD_compressBound(count);
            out.resize(start + 1 + kRoom + bound);
            std::uint8_t* frame = out.data() + start + 1 + kRoom;
            const std::size_t size = ZSTD_compressCCtx(zstd, frame, bound, bytes, count, kZstdLevel);
            CHECK(!ZSTD_isError(size), "{}", ZSTD_getErrorName(size));
            Bytes prefix;
            put_varint(prefix, size);
            if (size + prefix.size() < count) {
                std::memmove(out.data() + start + 1 + prefix.size(), frame, size);
                std::memcpy(out.data() + start + 1, prefix.data(), prefix.size());
                out.resize(start + 1 + prefix.size() + size);
                return;
            }
            out.resize(start);
        }
        out.push_back(static_cast<std::uint8_t>(PlaneMethod::kRaw));
        put_bytes(out, bytes, count);
    }

    template <typename T>
    void put_planes(const T* elements, std::size_t count, Bytes& out) {
        plane.resize(count);
        for (std::size_t p = 0; p < sizeof(T); ++p) {
            for (std::size_t i = 0; i < count; ++i)
                plane[i] = static_cast<std::uint8_t>(elements[i] >> (8 * p));
            put_plane(plane.data(), count, out);
        }
    }
};

ColumnEncoder::ColumnEncoder() : state_(std::make_unique<State>()) {}
ColumnEncoder::~ColumnEncoder() = default;

template <typename T>
void ColumnEncoder::encode(const T* elements, std::size_t count, Bytes& out) {
    CHECK(count > 0);
    State& s = *state_;
    s.filtered.resize(count * sizeof(T));
    s.indices.resize(count);
    T* filtered = reinterpret_cast<T*>(s.filtered.data());
    const std::size_t sample = std::min(count, kSampleElements);
    const std::size_t start = (count - sample) / 2;
    // A palette of many entries still costs its own bytes: the estimate is for the sample, so is their share.
    std::vector<T> palette;
    float best_bits = 0;
    ColumnFilter best = ColumnFilter::kNone;
    if (std::all_of(elements, elements + count, [&](T e) { return e == elements[0]; })) {
        out.push_back(static_cast<std::uint8_t>(ColumnFilter::kConstant));
        put_bytes(out, elements, sizeof(T));
        return;
    }
    for (const ColumnFilter filter :
         {ColumnFilter::kNone, ColumnFilter::kIncrement, ColumnFilter::kDelta1, ColumnFilter::kDelta4}) {
        apply_filter(filter, elements + start, sample, filtered);
        const float bits = sample_bits(filtered, sample);
        if (filter == ColumnFilter::kNone || bits < 0.99f * best_bits) {
            best = filter;
            best_bits = bits;
        }
    }
    if (sizeof(T) > 1 && build_palette(elements, count, palette, s.indices.data())) {
        const float share = static_cast<float>(sample) / static_cast<float>(count);
        const float bits = sample_bits(s.indices.data() + start, sample) +
                           share * static_cast<float>(8 * sizeof(T) * palette.size());
        if (bits < best_bits) best = ColumnFilter::kPalette;
    }
    out.push_back(static_cast<std::uint8_t>(best));
    if (best == ColumnFilter::kPalette) {
        out.push_back(static_cast<std::uint8_t>(palette.size() - 1));
        put_bytes(out, palette.data(), palette.size() * sizeof(T));
        s.put_plane(s.indices.data(), count, out);
        return;
    }
    apply_filter(best, elements, count, filtered);
    s.put_planes(filtered, count, out);
}

template void ColumnEncoder::encode(const std::uint8_t*, std::size_t, Bytes&);
template void ColumnEncoder::encode(const std::uint16_t*, std::size_t, Bytes&);
template void ColumnEncoder::encode(const std::uint32_t*, std::size_t, Bytes&);

}  // namespace ropsim
