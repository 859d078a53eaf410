#include "tests/fuzz/trace_parts.h"

#include <algorithm>

#include <xxhash.h>
#include <zstd.h>

namespace ropsim::fuzz {
namespace {

constexpr std::size_t kMaxIndexBytes = std::size_t{1} << 20;

Bytes take_section(const std::uint8_t* data, std::size_t size, const SectionRecord& section) {
    if (section.offset > size || section.stored_bytes > size - section.offset) throw FormatFault("outside");
    return {data + section.offset, data + section.offset + section.stored_bytes};
}

Bytes take_index(const std::uint8_t* data, std::size_t size, const TrailerRecord& trailer) {
    const Bytes stored = take_section(data, size, trailer.index);
    Bytes raw(kMaxIndexBytes);
    const std::size_t raw_size = ZSTD_decompress(raw.data(), raw.size(), stored.data(), stored.size());
    if (ZSTD_isError(raw_size)) throw FormatFault("index");
    raw.resize(raw_size);
    return raw;
}

template <typename T>
std::vector<T> take_records(ByteCursor& in, std::uint64_t count) {
    std::vector<T> records;
    for (std::uint64_t i = 0; i < count; ++i) records.push_back(in.record<T>());
    return records;
}

SectionRecord put_section(Bytes& out, const Bytes& bytes) {
    const SectionRecord record{out.size(), bytes.size(), XXH64(bytes.data(), bytes.size(), 0)};
    put_bytes(out, bytes.data(), bytes.size());
    return record;
}

}  // namespace

std::optional<TraceParts> take_apart(const std::uint8_t* data, std::size_t size) {
    try {
        if (size < sizeof(TrailerRecord)) return std::nullopt;
        ByteCursor file(data, size);
        const auto prologue = file.record<PrologueRecord>();
        TrailerRecord trailer;
        std::memcpy(&trailer, data + size - sizeof trailer, sizeof trailer);
        TraceParts parts;
        parts.header = take_section(data, size, prologue.header);
        parts.opaque = take_section(data, size, prologue.opaque);
        const Bytes index = take_index(data, size, trailer);
        ByteCursor in(index.data(), index.size());
        parts.totals = in.record<IndexRecord>();
        parts.chunks = take_records<ChunkRecord>(in, parts.totals.chunks);
        parts.blocks = take_records<BlockRecord>(in, parts.totals.blocks);
        const std::size_t tile_bytes = in.left();
        const std::uint8_t* tiles = in.take(tile_bytes);
        parts.tiles.assign(tiles, tiles + tile_bytes);
        std::uint64_t offset = prologue.opaque.offset + prologue.opaque.stored_bytes;
        for (const BlockRecord& block : parts.blocks) {
            parts.contents.push_back(take_section(data, size, {offset, block.stored_bytes, 0}));
            offset += block.stored_bytes;
        }
        return parts;
    } catch (const FormatFault&) {
        return std::nullopt;
    }
}

Bytes assemble(const TraceParts& parts) {
    Bytes out(sizeof(PrologueRecord));
    PrologueRecord prologue{};
    std::memcpy(prologue.magic, kTraceMagic.data(), sizeof prologue.magic);
    prologue.version = kTraceVersion;
    prologue.header = put_section(out, parts.header);
    prologue.opaque = put_section(out, parts.opaque);
    prologue.checksum = XXH64(&prologue, offsetof(PrologueRecord, checksum), 0);
    std::memcpy(out.data(), &prologue, sizeof prologue);

    IndexRecord totals = parts.totals;
    totals.chunks = parts.chunks.size();
    totals.blocks = parts.blocks.size();
    Bytes raw;
    put_bytes(raw, &totals, sizeof totals);
    put_bytes(raw, parts.chunks.data(), parts.chunks.size() * sizeof(ChunkRecord));
    for (std::size_t i = 0; i < parts.blocks.size(); ++i) {
        const SectionRecord section = put_section(out, parts.contents[i]);
        BlockRecord block = parts.blocks[i];
        block.stored_bytes = section.stored_bytes;
        block.checksum = section.checksum;
        put_bytes(raw, &block, sizeof block);
    }
    put_bytes(raw, parts.tiles.data(), parts.tiles.size());
    Bytes stored(ZSTD_compressBound(raw.size()));
    stored.resize(ZSTD_compress(stored.data(), stored.size(), raw.data(), raw.size(), 1));

    TrailerRecord trailer{};
    trailer.index = put_section(out, stored);
    trailer.index_raw_bytes = raw.size();
    trailer.file_bytes = out.size() + sizeof trailer;
    trailer.checksum = XXH64(&trailer, offsetof(TrailerRecord, checksum), 0);
    std::memcpy(trailer.magic, kTraceEndMagic.data(), sizeof trailer.magic);
    put_bytes(out, &trailer, sizeof trailer);
    return out;
}

}  // namespace ropsim::fuzz
