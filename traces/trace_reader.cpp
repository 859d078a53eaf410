// Reads trace files in arrival order, one chunk in memory at a time.
#include "base/error.h"
#include "base/huge_pages.h"
#include "traces/block_codec.h"
#include "traces/content_check.h"
#include "traces/kept_chunks.h"
#include "traces/least_alpha.h"
#include "traces/tile_selection.h"
#include "traces/trace.h"
#include "traces/trace_index.h"
#include "traces/trace_layout.h"
#include "traces/value_ranges.h"

#include <algorithm>

#include <fmt/format.h>
#include <xxhash.h>

namespace ropsim {

struct TraceReader::State {
    explicit State(const std::string& path)
        : file(path),
          index(read_index(file)),
          decoder(index.stored.header, index.columns),
          check(index),
          hash_text(ropsim::hash_text(index.stored.header, index.totals.hash, index.totals.slope_hash,
                                      index.totals.material_hash)) {
        rewind();
    }

    void rewind();
    bool wanted(const BlockRecord& record) const { return selection.region(record.region); }
    const BlockColumns& decode_block(const BlockRecord& block, const std::uint8_t* data);
    void load_chunk(std::size_t first, std::size_t end);
    void size_chunk(FragmentChunk& out, std::size_t count) const;
    void place(const BlockColumns& columns, std::size_t count, const RegionBounds& bounds,
               FragmentChunk& out);
    void place_selected(const BlockColumns& columns, std::size_t count, const RegionBounds& bounds);
    void decode_whole_chunk(FragmentChunk& out);
    void decode_selected(FragmentChunk& out);
    bool next(FragmentChunk& out, unsigned channels);
    void finish_check();

    TraceFile file;
    TraceIndex index;
    BlockDecoder decoder;
    ContentCheck check;
    std::string hash_text;
    std::vector<std::uint8_t> pending_selection;  // from the next rewind
    TileSelection selection;

    std::size_t chunk = 0;
    std::size_t block = 0;     // first block of `chunk`
    std::uint64_t offset = 0;  // of that block in the file
    std::uint64_t decoded_blocks = 0;
    unsigned wanted_channels = kNoChannels;  // in this chunk

    Bytes bytes;                     // the chunk's blocks as stored; only the wanted ones are read
    std::vector<std::uint8_t> seen;  // by rank
    FragmentChunk scattered;
    KeptChunks kept;     // of the selected tiles
    FragmentChunk bare;  // without channels, for callers that want fragments alone
};

void TraceReader::State::rewind() {
    chunk = 0;
    block = 0;
    offset = index.data_offset;
    const bool anew = selection.tiles() != pending_selection;
    selection.select(pending_selection, index);
    kept.rewind(anew, selection.decodes_mostly_others(index));
    check.start(selection.all());
}

// Reads the wanted blocks of [first, end) into `bytes`, neighbours in one go.
void TraceReader::State::load_chunk(std::size_t first, std::size_t end) {
    std::uint64_t total = 0;
    for (std::size_t b = first; b < end; ++b) total += index.blocks[b].stored_bytes;
    bytes.resize(std::max<std::uint64_t>(total, bytes.size()));
    std::uint64_t start = 0;
    for (std::size_t b = first; b < end;) {
        std::uint64_t run = 0;
        const bool want = wanted(index.blocks[b]);
        for (; b < end && wanted(index.blocks[b]) == want; ++b) run += index.blocks[b].stored_bytes;
        if (want) file.read(offset + start, bytes.data() + start, run);
        start += run;
    }
}

const BlockColumns& TraceReader::State::decode_block(const BlockRecord& record, const std::uint8_t* data) {
    const auto place = [&] { return fmt::format("chunk {}, region {}", chunk, record.region); };
    if (XXH64(data, record.stored_bytes, 0) != record.checksum)
        file.fail(place(), "does not match its checksum");
    ++decoded_blocks;
    try {
        return decoder.decode(data, record.stored_bytes, record.fragments, index.chunks[chunk].fragments,
                              region_bounds(index.stored.header, index.stored.region_side, record.region),
                              wanted_channels);
    } catch (const FormatFault& fault) {
        file.fail(place(), fault.what());
    }
}

void TraceReader::State::size_chunk(FragmentChunk& out, std::size_t count) const {
    if (out.fragments.capacity() < count) {
        out.fragments.reserve(count);
        prefer_huge_pages(out.fragments.data(), count * sizeof(Fragment));
    }
    out.fragments.resize(count);
    out.slopes.resize((wanted_channels & kSlopeChannels) && index.stored.header.depth_slopes ? count : 0);
    out.materials.resize((wanted_channels & kMaterialChannels) && index.stored.header.materials ? count : 0);
}

// Puts a block's elements where their ranks say.
void TraceReader::State::place(const BlockColumns& columns, std::size_t count, const RegionBounds& bounds,
                               FragmentChunk& out) {
    const std::uint32_t* const ranks = columns.rank.data();
    for (std::size_t i = 0; i < count; ++i) {
        out.fragments[ranks[i]] = columns.fragment(i, bounds);
        seen[ranks[i]] = 1;
    }
    if (!out.slopes.empty())
        for (std::size_t i = 0; i < count; ++i) out.slopes[ranks[i]] = columns.slope(i);
    if (!out.materials.empty())
        for (std::size_t i = 0; i < count; ++i) out.materials[ranks[i]] = columns.material(i);
}

void TraceReader::State::place_selected(const BlockColumns& columns, std::size_t count,
                                        const RegionBounds& bounds) {
    const auto tile_columns = static_cast<std::size_t>(tiles_across(index.stored.header.width));
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t tile =
            static_cast<std::size_t>((bounds.top + columns.y[i]) / kTileSize) * tile_columns +
            static_cast<std::size_t>((bounds.left + columns.x[i]) / kTileSize);
        if (!selection.tile(tile)) continue;
        const std::uint32_t rank = columns.rank[i];
        if (seen[rank]) file.fail(fmt::format("chunk {}", chunk), "holds a rank twice");
        seen[rank] = 1;
        scattered.fragments[rank] = columns.fragment(i, bounds);
        if (!scattered.slopes.empty()) scattered.slopes[rank] = columns.slope(i);
        if (!scattered.materials.empty()) scattered.materials[rank] = columns.material(i);
    }
}

void TraceReader::State::decode_whole_chunk(FragmentChunk& out) {
    const ChunkRecord& record = index.chunks[chunk];
    size_chunk(out, record.fragments);
    seen.assign(record.fragments, 0);
    const std::uint8_t* data = bytes.data();
    for (std::size_t b = block; b < block + record.blocks; ++b) {
        const BlockRecord& stored = index.blocks[b];
        const BlockColumns& columns = decode_block(stored, data);
        data += stored.stored_bytes;
        const RegionBounds bounds =
            region_bounds(index.stored.header, index.stored.region_side, stored.region);
        place(columns, stored.fragments, bounds, out);
    }
    // As many ranks as fragments, each below their number, and none left out: a permutation.
    std::uint32_t present = 0;
    for (const std::uint8_t s : seen) present += s;
    if (present != record.fragments) file.fail(fmt::format("chunk {}", chunk), "holds a rank twice");
}

void TraceReader::State::decode_selected(FragmentChunk& out) {
    const ChunkRecord& record = index.chunks[chunk];
    const auto first = index.blocks.begin() + static_cast<std::ptrdiff_t>(block);
    out.clear();
    if (std::none_of(first, first + record.blocks, [&](const BlockRecord& b) { return wanted(b); })) return;
    size_chunk(scattered, record.fragments);
    seen.assign(record.fragments, 0);
    const std::uint8_t* data = bytes.data();
    for (std::size_t b = block; b < block + record.blocks; ++b) {
        const BlockRecord& stored = index.blocks[b];
        if (wanted(stored)) {
            const BlockColumns& columns = decode_block(stored, data);
            const RegionBounds bounds =
                region_bounds(index.stored.header, index.stored.region_side, stored.region);
            place_selected(columns, stored.fragments, bounds);
        }
        data += stored.stored_bytes;
    }
    for (std::uint32_t rank = 0; rank < record.fragments; ++rank) {
        if (!seen[rank]) continue;
        out.fragments.push_back(scattered.fragments[rank]);
        if (!scattered.slopes.empty()) out.slopes.push_back(scattered.slopes[rank]);
        if (!scattered.materials.empty()) out.materials.push_back(scattered.materials[rank]);
    }
}

void TraceReader::State::finish_check() {
    try {
        check.finish();
    } catch (const FormatFault& fault) {
        file.fail("the content", fault.what());
    }
}

bool TraceReader::State::next(FragmentChunk& out, unsigned channels) {
    wanted_channels = channels;
    if (kept.holds(channels)) {
        if (kept.next(out)) return true;
        out.clear();
        return false;
    }
    while (chunk < index.chunks.size()) {
        const std::size_t end = block + index.chunks[chunk].blocks;
        load_chunk(block, end);
        if (selection.all()) {
            decode_whole_chunk(out);
            check.add(out);
            if (chunk + 1 == index.chunks.size()) finish_check();
        } else {
            decode_selected(out);
        }
        for (; block < end; ++block) offset += index.blocks[block].stored_bytes;
        ++chunk;
        if (!out.empty() && !selection.all()) kept.keep(out, channels);
        if (!out.empty()) return true;  // an unselected chunk is no chunk
    }
    if (!selection.all()) kept.finish();
    if (index.chunks.empty()) finish_check();  // header and opaque layer alone
    out.clear();
    return false;
}

TraceReader::TraceReader(const std::string& path) : state_(std::make_unique<State>(path)) {}
TraceReader::~TraceReader() = default;
TraceReader::TraceReader(TraceReader&&) noexcept = default;
TraceReader& TraceReader::operator=(TraceReader&&) noexcept = default;

const std::string& TraceReader::path() const {
    return state_->file.path();
}
const TraceHeader& TraceReader::header() const {
    return state_->index.stored.header;
}
std::uint64_t TraceReader::fragment_count() const {
    return state_->index.totals.fragments;
}
std::uint64_t TraceReader::file_bytes() const {
    return state_->file.size();
}
const std::string& TraceReader::hash() const {
    return state_->hash_text;
}
const std::vector<std::uint64_t>& TraceReader::tile_fragments() const {
    return state_->index.tiles;
}
std::uint64_t TraceReader::decoded_blocks() const {
    return state_->decoded_blocks;
}

bool TraceReader::next(std::vector<Fragment>& fragments) {
    // The caller's memory is reused for the next chunk.
    std::swap(state_->bare.fragments, fragments);
    const bool more = state_->next(state_->bare, kNoChannels);
    std::swap(state_->bare.fragments, fragments);
    if (header().non_finite)
        for (Fragment& fragment : fragments) bring_into_range(fragment);
    return more;
}

bool TraceReader::next(FragmentChunk& chunk, unsigned wanted) {
    const bool lessens = (wanted & kLeastAlpha) != 0;
    const bool more = state_->next(chunk, (wanted & kAllChannels) | (lessens ? kMaterialChannels : 0u));
    if (header().non_finite) {
        for (Fragment& fragment : chunk.fragments) bring_into_range(fragment);
        for (DepthSlope& slope : chunk.slopes) bring_into_range(slope);
        for (Material& material : chunk.materials) bring_into_range(material);
    }
    if (lessens) {
        for (std::size_t i = 0; i < chunk.materials.size(); ++i)
            chunk.fragments[i].a = least_alpha(chunk.fragments[i].a, chunk.materials[i]);
        if ((wanted & kMaterialChannels) == 0) chunk.materials.clear();
    }
    return more;
}

bool TraceReader::next_raw(FragmentChunk& chunk) {
    return state_->next(chunk, kAllChannels);
}

void TraceReader::select_tiles(std::vector<std::uint8_t> selected) {
    CHECK(selected.empty() || selected.size() == state_->index.tiles.size(), "{} flags for {} tiles",
          selected.size(), state_->index.tiles.size());
    state_->pending_selection = std::move(selected);
}

void TraceReader::rewind() {
    state_->rewind();
}

}  // namespace ropsim
