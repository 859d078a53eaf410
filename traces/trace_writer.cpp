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
#include "traces/value_ranges.h"

#include <algorithm>
#include <cerrno>
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

void round_to_half(float& value) {
    value = float_from_half(half_from_float(value));
}

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
    void check_fragment(const Fragment& fragment) const;
    void check_channel(bool good, const Fragment& fragment) const;
    void take(const Fragment& fragment, const DepthSlope* slope, const Material* material);
    void start_chunk();
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
    FragmentChunk filling;
    bool finished = false;

    // The helper thread's, while `helper` is valid.
    std::future<void> helper;
    FragmentChunk chunk;
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
    start_chunk();

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

void TraceWriter::State::check_fragment(const Fragment& f) const {
    CHECK(f.x < header.width && f.y < header.height, "fragment {} at ({}, {})", fragments, f.x, f.y);
    CHECK(f.draw < header.draws.size(), "fragment {}: draw {} of {}", fragments, f.draw, header.draws.size());
    CHECK(f.coverage < (1u << header.samples), "fragment {}: coverage {:#x}", fragments, f.coverage);
    if (!in_range(f) && !header.non_finite) [[unlikely]]
        throw UserError(
            file.path(),
            fmt::format("fragment {} at pixel ({}, {}): z={} r={} g={} b={} a={}: z and a must be from 0 "
                        "to 1, colours finite",
                        fragments, f.x, f.y, f.z, f.r, f.g, f.b, f.a));
}

void TraceWriter::State::check_channel(bool good, const Fragment& f) const {
    if (!good && !header.non_finite) [[unlikely]]
        throw UserError(
            file.path(),
            fmt::format("fragment {} at pixel ({}, {}): its depth slope or material is out of "
                        "range: transmission and collimation must be from 0 to 1, the rest finite",
                        fragments, f.x, f.y));
}

// One fragment, with null for defaults.
void TraceWriter::State::take(const Fragment& fragment, const DepthSlope* slope, const Material* material) {
    check_fragment(fragment);
    ++tiles[static_cast<std::size_t>(fragment.y / kTileSize) * tile_columns + fragment.x / kTileSize];
    filling.fragments.push_back(fragment);
    const bool halves = header.color_storage == ColorStorage::kFloat16;
    if (halves)
        for (const auto channel : {&Fragment::r, &Fragment::g, &Fragment::b})
            round_to_half(filling.fragments.back().*channel);
    if (header.depth_slopes) {
        filling.slopes.push_back(slope != nullptr ? *slope : DepthSlope{});
        check_channel(in_range(filling.slopes.back()), fragment);
    }
    if (header.materials) {
        filling.materials.push_back(material != nullptr ? *material : Material{});
        Material& m = filling.materials.back();
        check_channel(in_range(m), fragment);
        if (halves) {
            for (int c = 0; c < 3; ++c) {
                round_to_half(m.transmission[c]);
                round_to_half(m.normal[c]);
            }
            round_to_half(m.collimation);
            round_to_half(m.eta);
        }
    }
    ++fragments;
    if (filling.size() == static_cast<std::size_t>(layout.chunk_fragments)) hand_over();
}

// Stable counting sort: within a region the ranks rise.
void TraceWriter::State::sort_by_region() {
    const auto side = static_cast<unsigned>(layout.region_side);
    const auto across = static_cast<unsigned>(regions_across(header, layout.region_side));
    const auto region_of = [&](const Fragment& f) { return f.y / side * across + f.x / side; };
    const auto regions =
        static_cast<std::size_t>(across) * static_cast<std::size_t>(regions_down(header, layout.region_side));
    region_start.assign(regions + 1, 0);
    for (const Fragment& fragment : chunk.fragments) ++region_start[region_of(fragment) + 1];
    std::partial_sum(region_start.begin(), region_start.end(), region_start.begin());
    std::vector<std::uint32_t> next(region_start.begin(), region_start.end() - 1);
    ranks.resize(chunk.size());
    for (std::uint32_t rank = 0; rank < chunk.size(); ++rank)
        ranks[next[region_of(chunk.fragments[rank])]++] = rank;
}

void TraceWriter::State::write_chunk() {
    sort_by_region();
    ChunkRecord record{static_cast<std::uint32_t>(chunk.size()), 0};
    for (std::uint32_t region = 0; region + 1 < region_start.size(); ++region) {
        const std::uint32_t count = region_start[region + 1] - region_start[region];
        if (count == 0) continue;
        encoded.clear();
        encoder.encode(chunk, &ranks[region_start[region]], count,
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

void TraceWriter::State::start_chunk() {
    const auto full = static_cast<std::size_t>(layout.chunk_fragments);
    filling.clear();
    filling.fragments.reserve(full);
    if (header.depth_slopes) filling.slopes.reserve(full);
    if (header.materials) filling.materials.reserve(full);
}

void TraceWriter::State::hand_over() {
    hash.add(filling);
    await_helper();
    std::swap(filling, chunk);
    start_chunk();
    // Where the system gives no thread, by the one who waits for it.
    helper = std::async(std::launch::async | std::launch::deferred, [this] { write_chunk(); });
}

void TraceWriter::State::write_index() {
    Bytes raw;
    const IndexRecord record{fragments,        chunks.size(), blocks.size(),
                             hash.fragments(), hash.slopes(), hash.materials()};
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
    CHECK(!state_->finished);
    for (std::size_t i = 0; i < count; ++i) state_->take(fragments[i], nullptr, nullptr);
}

void TraceWriter::append(const FragmentChunk& chunk) {
    State& s = *state_;
    CHECK(!s.finished);
    CHECK(chunk.slopes.size() == (s.header.depth_slopes ? chunk.size() : 0) &&
              chunk.materials.size() == (s.header.materials ? chunk.size() : 0),
          "{} fragments, {} slopes, {} materials", chunk.size(), chunk.slopes.size(), chunk.materials.size());
    for (std::size_t i = 0; i < chunk.size(); ++i)
        s.take(chunk.fragments[i], chunk.slopes.empty() ? nullptr : &chunk.slopes[i],
               chunk.materials.empty() ? nullptr : &chunk.materials[i]);
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
