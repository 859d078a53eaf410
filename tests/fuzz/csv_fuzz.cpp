// Fuzzes the import of CSV: what is accepted becomes a trace that can be read.
#include "tests/fuzz/fuzz_input.h"
#include "traces/interchange/csv.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ropsim;
    const fuzz::InputFile input(data, size);
    const std::string trace = fuzz::scratch_path("csv.trace");
    if (fuzz::accepted([&] { import_csv(input.path(), trace); })) {
        CHECK(fuzz::accepted([&] { fuzz::read_whole_trace(trace); }));
    }
    return 0;
}
