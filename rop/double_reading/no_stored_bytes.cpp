// In place of rop/stored_bytes.cpp in the double-precision reading, whose values are in no stored format.
#include "base/error.h"
#include "rop/stored_bytes.h"

namespace ropsim {

void store_elements(const Surface&, const std::uint32_t*, std::uint64_t, std::uint8_t*) {
    CHECK(false, "bytes as stored in the double-precision reading");
}

}  // namespace ropsim
