// Fuzzes the import of deep OpenEXR: what is accepted becomes a trace that can be read.
#include "tests/fuzz/fuzz_input.h"
#include "traces/interchange/deep_exr.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ropsim;
    const fuzz::InputFile input(data, size);
    const std::string trace = fuzz::scratch_path("deep_exr.trace");
    if (fuzz::accepted([&] { import_deep_exr(input.path(), trace); })) {
        CHECK(fuzz::accepted([&] { fuzz::read_whole_trace(trace); }));
    }
    return 0;
}
