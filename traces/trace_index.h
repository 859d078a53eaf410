// Opening a trace file: prologue, header, opaque layer, index and trailer, each checked before it is
// believed.
#pragma once

#include "traces/trace_header.h"
#include "traces/trace_layout.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// A file opened for reads at offsets. Faults are UserErrors that name it.
class TraceFile {
 public:
    explicit TraceFile(std::string path);
    ~TraceFile();
    TraceFile(const TraceFile&) = delete;
    TraceFile& operator=(const TraceFile&) = delete;

    const std::string& path() const { return path_; }
    std::uint64_t size() const { return size_; }
    // Throws UserError when the file system refuses or the file has become shorter.
    void read(std::uint64_t offset, void* data, std::uint64_t bytes) const;
    // "path: place what; how to mend it" as an exception.
    [[noreturn]] void fail(const std::string& place, const std::string& what) const;

 private:
    std::string path_;
    int descriptor_ = -1;
    std::uint64_t size_ = 0;
};

struct TraceIndex {
    StoredHeader stored;
    std::vector<int> columns;  // ColumnId of each column of a block, -1: skip
    IndexRecord totals{};
    std::vector<ChunkRecord> chunks;
    std::vector<BlockRecord> blocks;
    std::vector<std::uint64_t> tiles;
    std::uint64_t data_offset = 0;  // of the first block
};

// Reads and checks everything but the blocks. Throws UserError.
TraceIndex read_index(const TraceFile& file);

}  // namespace ropsim
