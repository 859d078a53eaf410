// Of a technique by its text: worst-case bytes a fragment, and storage.
#pragma once

#include "tests/rop/random_fragments.h"

#include <string>

namespace ropsim::test {

inline ByteCount worst_case_bytes(const std::string& technique, int spatial_samples = 1) {
    const auto operation = TestFrame::make(technique, header_of(4, 4, spatial_samples));
    return ropsim::worst_case_bytes(operation->declaration(), operation->cost(plain_shape()));
}

inline int storage_bits(const std::string& technique, int spatial_samples = 1) {
    return TestFrame::make(technique, header_of(4, 4, spatial_samples))
        ->declaration()
        .storage_bits_per_pixel();
}

}  // namespace ropsim::test
