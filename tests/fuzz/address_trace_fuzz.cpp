// Fuzzes the reader of address traces: what is accepted is the same when it is written and read again.
#include "memory/address_trace.h"
#include "tests/fuzz/fuzz_input.h"

#include <vector>

namespace {

using namespace ropsim;

std::vector<AddressRequest> read_all(const std::string& path) {
    AddressTraceReader reader(path);
    std::vector<AddressRequest> all;
    std::vector<AddressRequest> block;
    while (reader.next(block)) {
        CHECK(!block.empty());
        all.insert(all.end(), block.begin(), block.end());
    }
    CHECK(block.empty() && !all.empty());
    return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::InputFile input(data, size);
    std::vector<AddressRequest> requests;
    if (!fuzz::accepted([&] { requests = read_all(input.path()); })) return 0;
    std::string text;
    for (const AddressRequest& request : requests) append_trace_line(text, request);
    const fuzz::InputFile written(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    std::vector<AddressRequest> again;
    CHECK(fuzz::accepted([&] { again = read_all(written.path()); }));
    CHECK(again.size() == requests.size());
    for (std::size_t i = 0; i < again.size(); ++i)
        CHECK(again[i].address == requests[i].address && again[i].cycle == requests[i].cycle &&
                  again[i].write == requests[i].write,
              "request {}", i);
    return 0;
}
