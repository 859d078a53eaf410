// Writes trace files: fills a chunk while a helper thread compresses and writes the one before.
#include "base/atomic_file.h"
#include "base/error.h"
#include "traces/block_codec.h"
#include "traces/content_hash.h"
#include "traces/half_float.h"
#include "traces/opaque_section.h"
#include "traces/trace.h"
#include "traces/trace_header.h"
#include "traces/trace_layout.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <future>
#include <numeric>

#include <xxhash.h>
#include <zstd.h>

namespace ropsim {

namespace {

constexpr int kIndexZstdLevel = 3;

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

int regions_across(const TraceHeader& header, int side) {
    return (header.width + side - 1) / side;
}
int regions_down(const TraceHeader& header, int side) {
    return (header.height + side - 1) / side;
}

}  // namespace

struct TraceWriter::State {
    State(const std::string& path, TraceHeader trace_header, TraceLayoutOptions options)
        : header(std::move(trace_header)), layout(options), file(path), hash(header) {}

    void open();
    void put(const void* data, std::size_t size);
    SectionRecord put_section(const void* data, std::size_t size);
    void check_values(const Fragment& fragment) const;
    void count_tile(const Fragment& fragment) {
        ++tiles[static_cast<std::size_t>(fragment.y / kTileSize) * tile_columns + fragment.x / kTileSize];
    }
    void hand_over();
    void await_helper();
    void write_chunk();
    void sort_by_region();
    void write_index();

    TraceHeader header;
    TraceLayoutOptions layout;
    AtomicFile file;
    std::unique_ptr<std::FILE, CloseFile> out;
    std::uint64_t offset = 0;
    ContentHash hash;
    std::uint64_t fragments = 0;
    std::size_t tile_columns = 0;
    std::vector<std::uint64_t> tiles;
    std::vector<Fragment> filling;
    bool finished = false;

    // The helper thread's, while `helper` is valid.
    std::future<void> helper;
    std::vector<Fragment> chunk;
    std::vector<std::uint32_t> ranks;         // of the chunk's fragments, region by region
    std::vector<std::uint32_t> region_start;  // first of each region in `ranks`, and the end
    BlockEncoder encoder;
    Bytes encoded;
    std::vector<ChunkRecord> chunks;
    std::vector<BlockRecord> blocks;
};

void TraceWriter::State::put(const void* data, std::size_t size) {
    if (size == 0) return;  // `data` may be null then
    if (std::fwrite(data, 1, size, out.get()) != size)
        throw UserError(file.path(), fmt::format("cannot write ({}); check the disk", std::strerror(errno)));
    offset += size;
}

SectionRecord TraceWriter::State::put_section(const void* data, std::size_t size) {
    const SectionRecord record{offset, size, XXH64(data, size, 0)};
    put(data, size);
    return record;
}

void TraceWriter::State::open() {
    if (const std::string fault = header_fault(header); !fault.empty()) throw UserError(file.path(), fault);
    CHECK(layout.chunk_fragments >= 1 && layout.chunk_fragments <= static_cast<int>(kMaxChunkFragments));
    CHECK(layout.region_side >= kTileSize && layout.region_side <= kMaxRegionSide &&
          layout.region_side % kTileSize == 0);
    out.reset(std::fopen(file.temporary_path().c_str(), "wb"));
    if (!out) throw UserError(file.path(), fmt::format("cannot write ({})", std::strerror(errno)));
    tile_columns = static_cast<std::size_t>(tiles_across(header.width));
    tiles.resize(tile_columns * static_cast<std::size_t>(tiles_across(header.height)));
    filling.reserve(static_cast<std::size_t>(layout.chunk_fragments));

    PrologueRecord prologue{};
    std::memcpy(prologue.magic, kTraceMagic.data(), sizeof(prologue.magic));
    prologue.version = kTraceVersion;
    // The prologue comes first and is known last.
    put(&prologue, sizeof(prologue));
    const std::string text = header_text(header, layout.region_side);
    prologue.header = put_section(text.data(), text.size());
    const Bytes opaque = header.opaque ? encode_opaque(*header.opaque) : Bytes{};
    prologue.opaque = put_section(opaque.data(), opaque.size());
    prologue.checksum = XXH64(&prologue, offsetof(PrologueRecord, checksum), 0);
    if (std::fseek(out.get(), 0, SEEK_SET) != 0 ||
        std::fwrite(&prologue, sizeof(prologue), 1, out.get()) != 1 ||
        std::fseek(out.get(), 0, SEEK_END) != 0)
        throw UserError(file.path(), fmt::format("cannot write ({}); check the disk", std::strerror(errno)));
}

void TraceWriter::State::check_values(const Fragment& f) const {
    CHECK(f.x < header.width && f.y < header.height, "fragment {} at ({}, {})", fragments, f.x, f.y);
    CHECK(f.draw < header.draws.size(), "fragment {}: draw {} of {}", fragments, f.draw, header.draws.size());
    CHECK(f.coverage < (1u << header.samples), "fragment {}: coverage {:#x}", fragments, f.coverage);
    const bool valid = f.z >= 0 && f.z <= 1 && f.a >= 0 && f.a <= 1 && std::isfinite(f.r) &&
                       std::isfinite(f.g) && std::isfinite(f.b);
    if (!valid) [[unlikely]]
        throw UserError(
            file.path(),
            fmt::format("fragment {} at pixel ({}, {}): z={} r={} g={} b={} a={}: z and a must be from 0 "
                        "to 1, colours finite",
                        fragments, f.x, f.y, f.z, f.r, f.g, f.b, f.a));
}

// Stable counting sort: within a region the ranks rise.
void TraceWriter::State::sort_by_region() {
    const auto side = static_cast<unsigned>(layout.region_side);
    const auto across = static_cast<unsigned>(regions_across(header, layout.region_side));
    const auto region_of = [&](const Fragment& f) { return f.y / side * across + f.x / side; };
    const auto regions =
        static_cast<std::size_t>(across) * static_cast<std::size_t>(regions_down(header, layout.region_side));
    region_start.assign(regions + 1, 0);
    for (const Fragment& fragment : chunk) ++region_start[region_of(fragment) + 1];
    std::partial_sum(region_start.begin(), region_start.end(), region_start.begin());
    std::vector<std::uint32_t> next(region_start.begin(), region_start.end() - 1);
    ranks.resize(chunk.size());
    for (std::uint32_t rank = 0; rank < chunk.size(); ++rank) ranks[next[region_of(chunk[rank])]++] = rank;
}

void TraceWriter::State::write_chunk() {
    sort_by_region();
    ChunkRecord record{static_cast<std::uint32_t>(chunk.size()), 0};
    for (std::uint32_t region = 0; region + 1 < region_start.size(); ++region) {
        const std::uint32_t count = region_start[region + 1] - region_start[region];
        if (count == 0) continue;
        encoded.clear();
        encoder.encode(chunk.data(), &ranks[region_start[region]], count,
                       region_bounds(header, layout.region_side, region), header.color_storage, encoded);
        blocks.push_back({region, count, encoded.size(), XXH64(encoded.data(), encoded.size(), 0)});
        put(encoded.data(), encoded.size());
        ++record.blocks;
    }
    chunks.push_back(record);
}

void TraceWriter::State::await_helper() {
    if (helper.valid()) helper.get();
}

void TraceWriter::State::hand_over() {
    hash.add(filling.data(), filling.size());
    await_helper();
    std::swap(filling, chunk);
    filling.clear();
    filling.reserve(static_cast<std::size_t>(layout.chunk_fragments));
    helper = std::async(std::launch::async, [this] { write_chunk(); });
}

void TraceWriter::State::write_index() {
    Bytes raw;
    const IndexRecord record{fragments, chunks.size(), blocks.size(), hash.value()};
    put_bytes(raw, &record, sizeof(record));
    put_bytes(raw, chunks.data(), chunks.size() * sizeof(ChunkRecord));
    put_bytes(raw, blocks.data(), blocks.size() * sizeof(BlockRecord));
    put_bytes(raw, tiles.data(), tiles.size() * sizeof(std::uint64_t));
    Bytes stored(ZSTD_compressBound(raw.size()));
    const std::size_t size =
        ZSTD_compress(stored.data(), stored.size(), raw.data(), raw.size(), kIndexZstdLevel);
    CHECK(!ZSTD_isError(size), "{}", ZSTD_getErrorName(size));

    TrailerRecord trailer{};
    trailer.index = put_section(stored.data(), size);
    trailer.index_raw_bytes = raw.size();
    trailer.file_bytes = offset + sizeof(trailer);
    trailer.checksum = XXH64(&trailer, offsetof(TrailerRecord, checksum), 0);
    std::memcpy(trailer.magic, kTraceEndMagic.data(), sizeof(trailer.magic));
    put(&trailer, sizeof(trailer));
}

TraceWriter::TraceWriter(const std::string& path, TraceHeader header, TraceLayoutOptions layout) {
    // Before the hash of its content: the hash of an inconsistent opaque layer would mean nothing.
    if (const std::string fault = header_fault(header); !fault.empty()) throw UserError(path, fault);
    state_ = std::make_unique<State>(path, std::move(header), layout);
    state_->open();
}

TraceWriter::~TraceWriter() {
    if (state_ && state_->helper.valid()) state_->helper.wait();
}

void TraceWriter::append(const Fragment* fragments, std::size_t count) {
    State& s = *state_;
    CHECK(!s.finished);
    const bool halves = s.header.color_storage == ColorStorage::kFloat16;
    const auto full = static_cast<std::size_t>(s.layout.chunk_fragments);
    for (std::size_t i = 0; i < count; ++i) {
        s.check_values(fragments[i]);
        s.count_tile(fragments[i]);
        s.filling.push_back(fragments[i]);
        if (halves)
            for (const auto channel : {&Fragment::r, &Fragment::g, &Fragment::b}) {
                float& value = s.filling.back().*channel;
                value = float_from_half(half_from_float(value));
            }
        ++s.fragments;
        if (s.filling.size() == full) s.hand_over();
    }
}

void TraceWriter::finish() {
    State& s = *state_;
    CHECK(!s.finished);
    if (!s.filling.empty()) s.hand_over();
    s.await_helper();
    s.write_index();
    if (std::fflush(s.out.get()) != 0)
        throw UserError(s.file.path(),
                        fmt::format("cannot write ({}); check the disk", std::strerror(errno)));
    s.out.reset();
    s.file.commit();
    s.finished = true;
}

}  // namespace ropsim
