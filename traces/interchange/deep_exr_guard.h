// Holds what an OpenEXR file claims about its sizes against the file, before OpenEXR believes it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// What the walk finds of one part.
struct ExrPartShape {
    std::string type;  // "deepscanline", ...; empty in single-part files that have none
    std::vector<std::uint64_t>
        row_bytes;  // of deep scanline parts, by row: bytes of its samples when unpacked
};

// Walks the file's headers, chunk tables and deep chunks: every attribute, table and chunk must lie within
// the file, a side be 1 to 16384 pixels, and what a deep row claims to unpack to be no more than its packed
// bytes can hold. OpenEXR 3.1 allocates by such claims (an attribute's size up to 2 GiB, a row's up to 2^64).
// Of flat parts the sides are at most 65536, and what is unpacked at once must be in proportion to the file;
// their chunks are left to OpenEXR. Throws UserError.
std::vector<ExrPartShape> check_exr_claims(const std::string& path);

}  // namespace ropsim
