// The worst case over an operation's own control paths: the papers' model of bytes a fragment.
#pragma once

#include "tests/rop/random_fragments.h"

#include <algorithm>
#include <string>

namespace ropsim::test {

// Bytes of one fragment through all passes of one round, no cache, no compression: for each pass and surface
// the most that any control path moves.
inline AccessBytes worst_case_bytes(const std::string& technique, int spatial_samples = 1) {
    const auto operation = TestFrame::make(technique, header_of(4, 4, spatial_samples));
    const Declaration& declared = operation->declaration();
    const CostTable table = operation->cost(plain_shape());
    AccessBytes bytes;
    for (int pass = 0; pass < static_cast<int>(declared.passes.size()); ++pass) {
        if (declared.passes[static_cast<std::size_t>(pass)].kind == PassKind::kImage) continue;
        for (std::size_t s = 0; s < declared.surfaces.size(); ++s) {
            std::uint64_t read = 0;
            std::uint64_t write = 0;
            for (const PathCost& path : table) {
                if (path.pass != pass) continue;
                read = std::max(read, access_bytes(declared.surfaces[s], path.worst[s].read));
                write = std::max(write, access_bytes(declared.surfaces[s], path.worst[s].write));
            }
            bytes.read += read;
            bytes.write += write;
        }
    }
    return bytes;
}

inline int storage_bits(const std::string& technique, int spatial_samples = 1) {
    return TestFrame::make(technique, header_of(4, 4, spatial_samples))
        ->declaration()
        .storage_bits_per_pixel();
}

}  // namespace ropsim::test
