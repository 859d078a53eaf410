// Fuzzes the reader of flat OpenEXR images: what is accepted is the same when it is written and read again.
#include "tests/fuzz/fuzz_input.h"
#include "traces/image.h"

#include <cstring>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ropsim;
    const fuzz::InputFile input(data, size);
    Image image;
    if (!fuzz::accepted([&] { image = read_exr(input.path()); })) return 0;
    CHECK(image.width > 0 && image.height > 0 && !image.channels.empty());
    CHECK(image.values.size() == static_cast<std::size_t>(image.width) *
                                     static_cast<std::size_t>(image.height) * image.channels.size());
    if (image.values.size() > std::size_t{1} << 16) return 0;
    const std::string path = fuzz::scratch_path("image.exr");
    Image again;
    CHECK(fuzz::accepted([&] {
        write_exr(path, image);
        again = read_exr(path);
    }));
    CHECK(again.width == image.width && again.height == image.height && again.channels == image.channels);
    CHECK(std::memcmp(again.values.data(), image.values.data(), image.values.size() * sizeof(float)) == 0);
    return 0;
}
