// The benchmark's own traces: layers over a square, of any size, the same on every machine.
#pragma once

#include <cstdint>
#include <string>

namespace ropsim {

struct LayeredSize {
    int covered = 1;  // pixels on a side with fragments
    int layers = 1;
    int image = 1;  // pixels on a side; the others are empty

    std::uint64_t fragments() const {
        return static_cast<std::uint64_t>(covered) * static_cast<std::uint64_t>(covered) *
               static_cast<std::uint64_t>(layers);
    }
};

// Where the trace of this size lies, or will.
std::string layered_trace(const std::string& directory, const LayeredSize& size);
// Writes it; memory does not grow with it. Throws UserError.
void make_layered_trace(const std::string& file, const LayeredSize& size);

}  // namespace ropsim
