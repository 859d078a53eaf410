// What the log adds up, against numbers counted by hand.
#include "rop/operation_log.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

// A node's number is no mask of elements, however small it is.
TEST(OperationLog, CountsAWrittenNodeOnce) {
    Declaration declaration;
    declaration.paths.resize(1);
    declaration.surfaces.resize(2);
    declaration.surfaces[0].layout = Layout::kPool;
    OperationLog log(declaration, false);
    PixelAccess access{};
    for (std::uint64_t node = 1; node <= 300; ++node) {
        access[0].write = node;
        access[1] = {node, node};
        log.add(0, access, {});
    }
    std::uint64_t bits = 0;
    for (std::uint64_t mask = 1; mask <= 300; ++mask) bits += count_elements(mask);
    EXPECT_EQ(log.write_elements(0), 300u);
    EXPECT_EQ(log.write_elements(1), bits);
    EXPECT_EQ(log.read_elements(1), bits);
}

}  // namespace
}  // namespace ropsim
