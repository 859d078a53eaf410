// Sectors of a line as the requests they make: one for each run of neighbours.
#pragma once

#include "memory/bit_count.h"
#include "memory/rop_cache.h"
#include "memory/tlm_memory_port.h"

#include <bit>
#include <cstdint>

namespace ropsim {

// A fill's id: miss register, first sector and one less than their number, from high to low.
inline constexpr int kFillRegisterShift = 10;
inline constexpr int kFillSectorShift = 5;
inline constexpr std::uint32_t kFillField = (1u << kFillSectorShift) - 1u;

// The sectors that a fill's id names.
inline std::uint32_t fill_sectors(std::uint32_t id) {
    return ~0u >> (31 - (id & kFillField)) << (id >> kFillSectorShift & kFillField);
}

struct SectorRun {
    std::uint32_t first;
    std::uint32_t length;
    std::uint32_t fill_id(std::uint32_t miss_register) const {
        return miss_register << kFillRegisterShift | first << kFillSectorShift | (length - 1);
    }
};

// The first run of `sectors`, at least one, which loses it.
inline SectorRun take_run(std::uint32_t& sectors) {
    const auto first = static_cast<std::uint32_t>(std::countr_zero(sectors));
    const auto length = static_cast<std::uint32_t>(std::countr_one(sectors >> first));
    sectors &= ~(~0u >> (32 - length) << first);
    return {first, length};
}

// Calls visit(MemoryRequest) for each run of `sectors` (a bit each) of a line. `request` gives what they have
// in common; its id is the miss register of a fill. `enables`: dirty bytes
// of the line for a masked write, or null; a request's own live as long as the visit.
template <class Visit>
void for_each_run(std::uint64_t line_address, std::uint32_t sectors, std::uint32_t sector_bytes,
                  MemoryRequest request, const LineMask* enables, Visit&& visit) {
    const std::uint32_t miss_register = request.id;
    while (sectors != 0) {
        const SectorRun run = take_run(sectors);
        request.address = line_address + std::uint64_t{run.first} * sector_bytes;
        request.bytes = run.length * sector_bytes;
        request.id = request.write ? 0 : run.fill_id(miss_register);
        LineMask mask;
        if (enables != nullptr && request.masked) {
            mask = enables->part(run.first * sector_bytes, request.bytes);
            request.enables = &mask;
        }
        visit(request);
    }
}

// What an eviction's runs have in common.
inline MemoryRequest write_back_request(const Eviction& eviction, std::uint32_t sector_bytes,
                                        MemoryCause cause) {
    const auto whole = bits_set(eviction.sectors) * sector_bytes;
    MemoryRequest request;
    request.write = true;
    request.masked = eviction.dirty_bytes < whole;
    request.surface = eviction.surface;
    request.cause = cause;
    return request;
}

}  // namespace ropsim
