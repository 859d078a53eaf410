// The opaque layer's section of a trace file.
#include "traces/opaque_section.h"

#include "traces/column_codec.h"

#include <algorithm>
#include <bit>

namespace ropsim {

namespace {

constexpr std::size_t kRunElements = 1u << 18;
constexpr std::size_t kChannels = 4;

// Channel c of element i: r, g, b, then depth.
template <typename Opaque>
auto& value_of(Opaque& opaque, std::size_t element, std::size_t channel) {
    return channel < 3 ? opaque.rgb[3 * element + channel] : opaque.depth[element];
}

}  // namespace

Bytes encode_opaque(const OpaqueLayer& opaque) {
    ColumnEncoder encoder;
    Bytes section;
    Bytes column;
    std::vector<std::uint32_t> bits;
    for (std::size_t start = 0; start < opaque.depth.size(); start += kRunElements) {
        const std::size_t count = std::min(kRunElements, opaque.depth.size() - start);
        bits.resize(count);
        for (std::size_t channel = 0; channel < kChannels; ++channel) {
            for (std::size_t i = 0; i < count; ++i)
                bits[i] = std::bit_cast<std::uint32_t>(value_of(opaque, start + i, channel));
            column.clear();
            encoder.encode(bits.data(), count, column);
            put_varint(section, column.size());
            put_bytes(section, column.data(), column.size());
        }
    }
    return section;
}

OpaqueLayer decode_opaque(const Bytes& section, std::size_t elements) {
    ByteCursor in(section.data(), section.size());
    ColumnDecoder decoder;
    OpaqueLayer opaque;
    std::vector<std::uint32_t> bits;
    for (std::size_t start = 0; start < elements; start += kRunElements) {
        const std::size_t count = std::min(kRunElements, elements - start);
        bits.resize(count);
        // Grows with the data that was there, not with what the header claims.
        opaque.rgb.resize(3 * (start + count));
        opaque.depth.resize(start + count);
        for (std::size_t channel = 0; channel < kChannels; ++channel) {
            const std::uint64_t bytes = in.varint();
            decoder.decode(ByteCursor(in.take(bytes), bytes), count, bits.data());
            for (std::size_t i = 0; i < count; ++i)
                value_of(opaque, start + i, channel) = std::bit_cast<float>(bits[i]);
        }
    }
    if (in.left() != 0) throw FormatFault("is longer than its columns");
    return opaque;
}

}  // namespace ropsim
