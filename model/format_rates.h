// How long a pixel lane is taken by the formats and the samples that an operation writes, whatever its
// arithmetic takes.
#pragma once

#include "base/parameters.h"
#include "rop/declaration.h"
#include "rop/pixel.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ropsim {

class SurfaceMap;

// Cycles of a lane for one sample of a colour surface with elements of up to so many bits, and how many
// samples of a pixel a lane takes side by side. Keys and sources: docs/hardware.md.
struct FormatRates {
    std::uint32_t bits_32 = 1;
    std::uint32_t bits_64 = 2;
    std::uint32_t bits_128 = 4;
    std::uint32_t samples_per_cycle = 1;

    // Wider elements are so many of 128 bits.
    std::uint32_t cycles(int element_bits) const {
        if (element_bits <= 32) return bits_32;
        if (element_bits <= 64) return bits_64;
        return bits_128 * static_cast<std::uint32_t>((element_bits + 127) / 128);
    }
};

// Keys rop.rate.bits_32, rop.rate.bits_64, rop.rate.bits_128, rop.samples_per_cycle.
FormatRates read_format_rates(Parameters& parameters);

// The same for the surfaces of a technique. Colour surfaces are those of SurfaceClass::kColor: one element a
// pixel that is not a depth, or elements kept in planes. Those that an operation writes follow one another,
// as a quad goes over several render targets one by one. Arrays and lists of nodes have no rate of their own:
// the cache's ports bound them. What is declared in planes, as multisampled targets are kept, has state for
// each sample: those that an operation reads or writes follow one another, of colours and depths alike.
class LaneTurns {
 public:
    LaneTurns(const Declaration& declaration, const SurfaceMap& map, const FormatRates& rates);

    // Cycles for the accesses of one operation to one pixel, by surface of the declaration; at least 1.
    // `resolves`: it writes the image, too.
    std::uint32_t cycles(const SurfaceAccess* access, bool resolves = false) const {
        std::uint32_t writes = resolves ? image_cycles_ : 0;
        for (const Turns& of : written_) writes += access[of.surface].write != 0 ? of.rate : 0;
        std::uint32_t most = 1;
        for (const Turns& of : sampled_) {
            const SurfaceAccess& a = access[of.surface];
            if (of.rate > 0) writes += of.rate * turns(a.write);
            most = std::max(most, turns(a.read | a.write));
        }
        return std::max(writes, most);
    }

 private:
    struct Turns {
        std::uint32_t surface = 0;
        std::uint32_t rate = 0;  // cycles a sample written; 0: not a colour
    };
    std::uint32_t turns(std::uint64_t samples) const;

    // Of the surfaces that can take more than a cycle: colours, and those whose elements are samples.
    std::vector<Turns> written_;
    std::vector<Turns> sampled_;
    std::uint32_t samples_per_cycle_;
    std::uint32_t image_cycles_;
};

}  // namespace ropsim
