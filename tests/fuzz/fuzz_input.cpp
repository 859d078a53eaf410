#include "tests/fuzz/fuzz_input.h"

#include "traces/content_hash.h"
#include "traces/trace.h"

#include <cstdlib>
#include <filesystem>

#include <sys/mman.h>
#include <unistd.h>

namespace ropsim::fuzz {
namespace {

struct ScratchFolder {
    ScratchFolder() {
        // Finished files are flushed to disk: not where that takes time.
        std::string name =
            std::filesystem::exists("/dev/shm") ? "/dev/shm/ropsim_fuzz_XXXXXX" : "/tmp/ropsim_fuzz_XXXXXX";
        CHECK(::mkdtemp(name.data()) != nullptr, "{}", name);
        path = name;
    }
    ~ScratchFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    std::string path;
};

void check_chunk(const FragmentChunk& chunk, const TraceHeader& header) {
    CHECK(chunk.slopes.size() == (header.depth_slopes ? chunk.size() : 0));
    CHECK(chunk.materials.size() == (header.materials ? chunk.size() : 0));
    for (const Fragment& fragment : chunk.fragments) {
        CHECK(fragment.x < header.width && fragment.y < header.height &&
              fragment.draw < header.draws.size() && fragment.coverage < 1u << header.samples);
        CHECK(header.non_finite ||
              (fragment.z >= 0 && fragment.z <= 1 && fragment.a >= 0 && fragment.a <= 1));
    }
}

}  // namespace

InputFile::InputFile(const std::uint8_t* data, std::size_t size)
    : descriptor_(::memfd_create("input", MFD_CLOEXEC)) {
    CHECK(descriptor_ >= 0);
    CHECK(::write(descriptor_, data, size) == static_cast<ssize_t>(size));
    path_ = fmt::format("/proc/self/fd/{}", descriptor_);
}

InputFile::~InputFile() {
    ::close(descriptor_);
}

std::string scratch_path(const std::string& name) {
    static const ScratchFolder folder;
    return folder.path + "/" + name;
}

void read_whole_trace(const std::string& path) {
    TraceReader reader(path);
    const TraceHeader& header = reader.header();
    ContentHash hash(header);
    std::uint64_t fragments = 0;
    FragmentChunk chunk;
    while (reader.next_raw(chunk)) {
        check_chunk(chunk, header);
        hash.add(chunk);
        fragments += chunk.size();
    }
    // A pass that ends without an error gave the data that the hash promises.
    CHECK(hash_text(header, hash.fragments(), hash.slopes(), hash.materials()) == reader.hash());
    CHECK(fragments == reader.fragment_count());
    reader.rewind();
    std::uint64_t again = 0;
    while (reader.next(chunk)) again += chunk.size();
    CHECK(again == fragments);
}

}  // namespace ropsim::fuzz
