// Reads trace files in arrival order, one chunk in memory at a time.
#include "base/error.h"
#include "traces/block_codec.h"
#include "traces/content_hash.h"
#include "traces/trace.h"
#include "traces/trace_index.h"
#include "traces/trace_layout.h"

#include <algorithm>

#include <fmt/format.h>
#include <xxhash.h>

namespace ropsim {

struct TraceReader::State {
    explicit State(const std::string& path)
        : file(path),
          index(read_index(file)),
          decoder(index.stored.header, index.columns),
          hash_text(fmt::format("{:016x}", index.totals.hash)) {
        rewind();
    }

    void rewind();
    bool wanted(const BlockRecord& record) const {
        return region_selected.empty() || region_selected[record.region] != 0;
    }
    void select_regions();
    const BlockColumns& decode_block(const BlockRecord& block, const std::uint8_t* data);
    void load_chunk(std::size_t first, std::size_t end);
    void decode_whole_chunk(std::vector<Fragment>& fragments);
    void decode_selected(std::vector<Fragment>& fragments);
    bool next(std::vector<Fragment>& fragments);
    void verify(const std::vector<Fragment>& fragments);

    TraceFile file;
    TraceIndex index;
    BlockDecoder decoder;
    std::string hash_text;
    std::vector<std::uint8_t> pending_selection;  // from the next rewind
    std::vector<std::uint8_t> tile_selected;      // empty: all
    std::vector<std::uint8_t> region_selected;

    std::size_t chunk = 0;
    std::size_t block = 0;     // first block of `chunk`
    std::uint64_t offset = 0;  // of that block in the file
    std::uint64_t decoded_blocks = 0;
    std::unique_ptr<ContentHash>
        hash;  // of what was read since the start; null once verified, or under a selection
    bool verified = false;

    Bytes bytes;                     // the chunk's blocks as stored; only the wanted ones are read
    std::vector<std::uint8_t> seen;  // by rank
    std::vector<Fragment> scattered;
};

void TraceReader::State::rewind() {
    chunk = 0;
    block = 0;
    offset = index.data_offset;
    tile_selected = pending_selection;
    select_regions();
    hash.reset();
    if (!verified && tile_selected.empty()) hash = std::make_unique<ContentHash>(index.stored.header);
}

void TraceReader::State::select_regions() {
    region_selected.clear();
    if (tile_selected.empty()) return;
    const TraceHeader& header = index.stored.header;
    const int side = index.stored.region_side;
    const auto columns = static_cast<std::size_t>((header.width + side - 1) / side);
    const auto rows = static_cast<std::size_t>((header.height + side - 1) / side);
    const auto tile_columns = static_cast<std::size_t>(tiles_across(header.width));
    const auto tiles_a_side = static_cast<std::size_t>(side / kTileSize);
    region_selected.assign(columns * rows, 0);
    for (std::size_t tile = 0; tile < tile_selected.size(); ++tile) {
        if (!tile_selected[tile]) continue;
        const std::size_t row = tile / tile_columns / tiles_a_side;
        const std::size_t column = tile % tile_columns / tiles_a_side;
        region_selected[row * columns + column] = 1;
    }
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
                              region_bounds(index.stored.header, index.stored.region_side, record.region));
    } catch (const FormatFault& fault) {
        file.fail(place(), fault.what());
    }
}

void TraceReader::State::decode_whole_chunk(std::vector<Fragment>& fragments) {
    const ChunkRecord& record = index.chunks[chunk];
    fragments.resize(record.fragments);
    seen.assign(record.fragments, 0);
    const std::uint8_t* data = bytes.data();
    for (std::size_t b = block; b < block + record.blocks; ++b) {
        const BlockRecord& stored = index.blocks[b];
        const BlockColumns& columns = decode_block(stored, data);
        data += stored.stored_bytes;
        const RegionBounds bounds =
            region_bounds(index.stored.header, index.stored.region_side, stored.region);
        Fragment* out = fragments.data();
        for (std::size_t i = 0; i < stored.fragments; ++i) {
            const std::uint32_t rank = columns.rank[i];
            out[rank] = columns.fragment(i, bounds);
            seen[rank] = 1;
        }
    }
    // As many ranks as fragments, each below their number, and none left out: a permutation.
    std::uint32_t present = 0;
    for (const std::uint8_t s : seen) present += s;
    if (present != record.fragments) file.fail(fmt::format("chunk {}", chunk), "holds a rank twice");
}

void TraceReader::State::decode_selected(std::vector<Fragment>& fragments) {
    const ChunkRecord& record = index.chunks[chunk];
    const auto first = index.blocks.begin() + static_cast<std::ptrdiff_t>(block);
    fragments.clear();
    if (std::none_of(first, first + record.blocks, [&](const BlockRecord& b) { return wanted(b); })) return;
    scattered.resize(std::max<std::size_t>(scattered.size(), record.fragments));
    seen.assign(record.fragments, 0);
    const auto tile_columns = static_cast<std::size_t>(tiles_across(index.stored.header.width));
    const std::uint8_t* data = bytes.data();
    for (std::size_t b = block; b < block + record.blocks; ++b) {
        const BlockRecord& stored = index.blocks[b];
        if (wanted(stored)) {
            const BlockColumns& columns = decode_block(stored, data);
            const RegionBounds bounds =
                region_bounds(index.stored.header, index.stored.region_side, stored.region);
            for (std::size_t i = 0; i < stored.fragments; ++i) {
                const Fragment fragment = columns.fragment(i, bounds);
                const std::size_t tile =
                    static_cast<std::size_t>(fragment.y / kTileSize) * tile_columns + fragment.x / kTileSize;
                if (!tile_selected[tile]) continue;
                const std::uint32_t rank = columns.rank[i];
                if (seen[rank]) file.fail(fmt::format("chunk {}", chunk), "holds a rank twice");
                seen[rank] = 1;
                scattered[rank] = fragment;
            }
        }
        data += stored.stored_bytes;
    }
    for (std::uint32_t rank = 0; rank < record.fragments; ++rank)
        if (seen[rank]) fragments.push_back(scattered[rank]);
}

void TraceReader::State::verify(const std::vector<Fragment>& fragments) {
    if (!hash) return;
    hash->add(fragments.data(), fragments.size());
    if (chunk + 1 != index.chunks.size()) return;
    if (hash->value() != index.totals.hash) file.fail("the content", "does not match its hash");
    verified = true;
    hash.reset();
}

bool TraceReader::State::next(std::vector<Fragment>& fragments) {
    while (chunk < index.chunks.size()) {
        const std::size_t end = block + index.chunks[chunk].blocks;
        load_chunk(block, end);
        if (tile_selected.empty()) {
            decode_whole_chunk(fragments);
            verify(fragments);
        } else {
            decode_selected(fragments);
        }
        for (; block < end; ++block) offset += index.blocks[block].stored_bytes;
        ++chunk;
        if (!fragments.empty()) return true;  // an unselected chunk is no chunk
    }
    fragments.clear();
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
    return state_->next(fragments);
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
