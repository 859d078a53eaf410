// Fuzzes TraceReader. Most mutations change one part of the file and make its sizes and checksums right
// again.
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/trace_parts.h"

#include <algorithm>
#include <random>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using ropsim::Bytes;
using ropsim::fuzz::TraceParts;

void mutate(Bytes& bytes, std::size_t room) {
    const std::size_t size = bytes.size();
    bytes.resize(size + std::min<std::size_t>(room, 64) + 1);
    bytes.resize(LLVMFuzzerMutate(bytes.data(), size, bytes.size()));
}

template <typename T>
void mutate_record(T& record) {
    LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(&record), sizeof record, sizeof record);
}

void mutate_part(TraceParts& parts, std::mt19937& random, std::size_t room) {
    // Blocks most often: they hold most of the format.
    const unsigned kind = random() % 16;
    if (kind < 9 && !parts.contents.empty()) {
        mutate(parts.contents[random() % parts.contents.size()], room);
    } else if (kind < 11) {
        mutate(parts.header, room);
    } else if (kind < 13) {
        mutate(parts.opaque, room);
    } else if (kind == 13 && !parts.blocks.empty()) {
        mutate_record(parts.blocks[random() % parts.blocks.size()]);
    } else if (kind == 14 && !parts.chunks.empty()) {
        mutate_record(parts.chunks[random() % parts.chunks.size()]);
    } else if (random() % 2 == 0) {
        mutate_record(parts.totals);
    } else {
        mutate(parts.tiles, room);
    }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
    std::mt19937 random(seed);
    std::optional<TraceParts> parts = ropsim::fuzz::take_apart(data, size);
    if (!parts || random() % 10 == 0) return LLVMFuzzerMutate(data, size, max_size);
    mutate_part(*parts, random, max_size > size ? max_size - size : 0);
    const Bytes file = ropsim::fuzz::assemble(*parts);
    if (file.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
    std::copy(file.begin(), file.end(), data);
    return file.size();
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ropsim;
    const fuzz::InputFile input(data, size);
    fuzz::accepted([&] { fuzz::read_whole_trace(input.path()); });
    return 0;
}
