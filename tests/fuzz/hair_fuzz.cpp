// Fuzzes the reader of .hair files: what is accepted is what HairFile promises.
#include "capture/files/hair_file.h"
#include "tests/fuzz/fuzz_input.h"

#include <cmath>

namespace {

bool finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check(const ropsim::HairFile& hair) {
    CHECK(hair.strands() > 0 && hair.first_points.front() == 0 &&
          hair.first_points.back() == hair.points.size());
    for (std::size_t i = 0; i < hair.strands(); ++i)
        CHECK(hair.first_points[i + 1] >= hair.first_points[i] + 2);
    CHECK(hair.thickness.size() == hair.points.size() && hair.transparency.size() == hair.points.size() &&
          hair.colors.size() == hair.points.size());
    for (std::size_t i = 0; i < hair.points.size(); ++i) {
        CHECK(finite(hair.points[i]) && finite(hair.colors[i]), "point {}", i);
        CHECK(hair.thickness[i] >= 0 && std::isfinite(hair.thickness[i]), "point {}", i);
        CHECK(hair.transparency[i] >= 0 && hair.transparency[i] <= 1, "point {}", i);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ropsim;
    fuzz::accepted([&] { check(parse_hair({data, size}, "input")); });
    return 0;
}
