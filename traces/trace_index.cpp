// Opening a trace file: prologue, header, opaque layer, index and trailer, each checked before it is
// believed.
#include "traces/trace_index.h"

#include "base/error.h"
#include "traces/opaque_section.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>
#include <zstd.h>

namespace ropsim {

namespace {

// A section's bytes, after its extent and checksum have been checked.
Bytes read_section(const TraceFile& file, const SectionRecord& section, const char* name) {
    if (section.offset > file.size() || section.stored_bytes > file.size() - section.offset)
        file.fail(name, "lies outside the file");
    Bytes bytes(section.stored_bytes);
    file.read(section.offset, bytes.data(), bytes.size());
    if (XXH64(bytes.data(), bytes.size(), 0) != section.checksum)
        file.fail(name, "does not match its checksum");
    return bytes;
}

PrologueRecord read_prologue(const TraceFile& file) {
    PrologueRecord prologue{};
    if (file.size() < kTraceMagic.size() + sizeof(TrailerRecord) + sizeof(PrologueRecord)) {
        char magic[8] = {};
        if (file.size() >= sizeof(magic)) file.read(0, magic, sizeof(magic));
        if (std::memcmp(magic, kTraceMagic.data(), sizeof(magic)) != 0)
            throw UserError(file.path(),
                            "is not a trace file; make one with `ropsim capture` or `ropsim trace import`");
        file.fail("the file", "is cut short");
    }
    file.read(0, &prologue, sizeof(prologue));
    if (std::memcmp(prologue.magic, kTraceMagic.data(), sizeof(prologue.magic)) != 0)
        throw UserError(file.path(),
                        "is not a trace file; make one with `ropsim capture` or `ropsim trace import`");
    if (prologue.version != kTraceVersion)
        throw UserError(file.path(),
                        fmt::format("has trace format version {}, this program reads version {}; capture "
                                    "or import it again",
                                    prologue.version, kTraceVersion));
    if (XXH64(&prologue, offsetof(PrologueRecord, checksum), 0) != prologue.checksum ||
        prologue.reserved != 0)
        file.fail("the prologue", "does not match its checksum");
    return prologue;
}

TrailerRecord read_trailer(const TraceFile& file) {
    TrailerRecord trailer{};
    file.read(file.size() - sizeof(trailer), &trailer, sizeof(trailer));
    if (std::memcmp(trailer.magic, kTraceEndMagic.data(), sizeof(trailer.magic)) != 0)
        file.fail("the end", "is missing: the file is cut short or was never finished");
    if (XXH64(&trailer, offsetof(TrailerRecord, checksum), 0) != trailer.checksum)
        file.fail("the trailer", "does not match its checksum");
    if (trailer.file_bytes != file.size()) file.fail("the file", "is not as long as it says");
    return trailer;
}

template <typename T>
std::vector<T> take_records(ByteCursor& in, std::uint64_t count) {
    if (count > in.left() / sizeof(T)) throw FormatFault("ends early");
    std::vector<T> records(count);
    const std::uint8_t* bytes = in.take(count * sizeof(T));
    if (count) std::memcpy(records.data(), bytes, count * sizeof(T));
    return records;
}

// The index's own consistency: every count and size adds up.
void check_totals(const TraceIndex& index, std::uint64_t data_bytes, std::uint64_t regions) {
    std::uint64_t fragments = 0;
    std::size_t block = 0;
    for (const ChunkRecord& chunk : index.chunks) {
        if (chunk.fragments == 0 || chunk.fragments > kMaxChunkFragments)
            throw FormatFault(fmt::format("claims a chunk of {} fragments", chunk.fragments));
        if (chunk.blocks > index.blocks.size() - block)
            throw FormatFault("has fewer blocks than its chunks need");
        std::uint64_t in_blocks = 0;
        for (const std::size_t end = block + chunk.blocks; block < end; ++block) {
            const BlockRecord& record = index.blocks[block];
            if (record.fragments == 0 || record.region >= regions || record.stored_bytes < kMinBlockBytes ||
                record.stored_bytes > data_bytes)
                throw FormatFault(fmt::format("describes block {} wrongly", block));
            in_blocks += record.fragments;
            data_bytes -= record.stored_bytes;
        }
        if (in_blocks != chunk.fragments) throw FormatFault("has blocks that do not add up to their chunk");
        fragments += chunk.fragments;
    }
    std::uint64_t in_tiles = 0;
    for (const std::uint64_t count : index.tiles) in_tiles += count;
    if (block != index.blocks.size() || data_bytes != 0 || fragments != index.totals.fragments ||
        in_tiles != fragments)
        throw FormatFault("does not add up");
}

void parse_index(const TraceFile& file, const TrailerRecord& trailer, TraceIndex& index) {
    const Bytes stored = read_section(file, trailer.index, "the index");
    const TraceHeader& header = index.stored.header;
    const auto tile_count = static_cast<std::uint64_t>(tiles_across(header.width)) *
                            static_cast<std::uint64_t>(tiles_across(header.height));
    if (trailer.index.offset < index.data_offset) throw FormatFault("lies before the blocks");
    const std::uint64_t data_bytes = trailer.index.offset - index.data_offset;
    // A block takes at least kMinBlockBytes of the file, a chunk at least one block: this bounds what is
    // allocated.
    const std::uint64_t largest = sizeof(IndexRecord) + 8 * tile_count +
                                  data_bytes / kMinBlockBytes * (sizeof(BlockRecord) + sizeof(ChunkRecord));
    if (trailer.index_raw_bytes > largest) throw FormatFault("claims more blocks than the file can hold");
    Bytes raw(trailer.index_raw_bytes);
    if (ZSTD_decompress(raw.data(), raw.size(), stored.data(), stored.size()) != raw.size())
        throw FormatFault("does not decode");
    ByteCursor in(raw.data(), raw.size());
    index.totals = in.record<IndexRecord>();
    index.chunks = take_records<ChunkRecord>(in, index.totals.chunks);
    index.blocks = take_records<BlockRecord>(in, index.totals.blocks);
    index.tiles = take_records<std::uint64_t>(in, tile_count);
    if (in.left() != 0) throw FormatFault("is longer than its contents");
    const auto side = index.stored.region_side;
    const auto regions = static_cast<std::uint64_t>((header.width + side - 1) / side) *
                         static_cast<std::uint64_t>((header.height + side - 1) / side);
    check_totals(index, data_bytes, regions);
}

}  // namespace

TraceFile::TraceFile(std::string path) : path_(std::move(path)) {
    descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0)
        throw UserError(path_, fmt::format("cannot open ({}); check the name", std::strerror(errno)));
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
        ::close(descriptor_);
        throw UserError(path_, "is not a regular file; give a trace file");
    }
    size_ = static_cast<std::uint64_t>(status.st_size);
}

TraceFile::~TraceFile() {
    ::close(descriptor_);
}

void TraceFile::read(std::uint64_t offset, void* data, std::uint64_t bytes) const {
    auto* out = static_cast<char*>(data);
    while (bytes > 0) {
        const ssize_t got = ::pread(descriptor_, out, bytes, static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw UserError(path_, fmt::format("cannot read ({})", std::strerror(errno)));
        if (got == 0) fail("the file", "has become shorter while it was read");
        out += got;
        offset += static_cast<std::uint64_t>(got);
        bytes -= static_cast<std::uint64_t>(got);
    }
}

void TraceFile::fail(const std::string& place, const std::string& what) const {
    throw UserError(path_,
                    fmt::format("{} {}; the file is damaged: capture, import or copy it again", place, what));
}

TraceIndex read_index(const TraceFile& file) {
    const PrologueRecord prologue = read_prologue(file);
    const TrailerRecord trailer = read_trailer(file);
    TraceIndex index;
    const char* place = "the header";
    try {
        const Bytes text = read_section(file, prologue.header, place);
        index.stored = parse_header({text.begin(), text.end()});
        index.columns = map_columns(index.stored.columns, index.stored.header);
        TraceHeader& header = index.stored.header;
        place = "the opaque layer";
        const Bytes opaque = read_section(file, prologue.opaque, place);
        if (!opaque.empty()) {
            header.opaque = decode_opaque(opaque, static_cast<std::size_t>(header.width) *
                                                      static_cast<std::size_t>(header.height) *
                                                      static_cast<std::size_t>(header.samples));
            if (const std::string fault = header_fault(header); !fault.empty())
                throw FormatFault("is wrong: " + fault);
        }
        place = "the index";
        index.data_offset = prologue.opaque.offset + prologue.opaque.stored_bytes;
        parse_index(file, trailer, index);
    } catch (const FormatFault& fault) {
        file.fail(place, fault.what());
    }
    return index;
}

}  // namespace ropsim
