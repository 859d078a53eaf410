// Fuzzes the reader of splat .ply files: what is accepted is what SplatFile promises.
#include "capture/files/splat_file.h"
#include "tests/fuzz/fuzz_input.h"

#include <cmath>

namespace {

void check(const ropsim::SplatFile& splats) {
    const std::size_t count = splats.size();
    CHECK(splats.degree >= 0 && splats.degree <= 3);
    CHECK(splats.scales.size() == count && splats.rotations.size() == count &&
          splats.opacities.size() == count && splats.harmonics.size() == count * splats.harmonics_a_splat());
    for (std::size_t i = 0; i < count; ++i) {
        CHECK(splats.opacities[i] >= 0 && splats.opacities[i] <= 1, "splat {}", i);
        CHECK(std::abs(glm::length(splats.rotations[i]) - 1) < 1e-3f, "splat {}", i);
        for (int axis = 0; axis < 3; ++axis)
            CHECK(std::isfinite(splats.positions[i][axis]) && splats.scales[i][axis] >= 0, "splat {}", i);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ropsim;
    fuzz::accepted([&] { check(parse_splats({data, size}, "input")); });
    return 0;
}
