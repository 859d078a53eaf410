// What goes into the command scheduler, and who sees what comes out of it.
#pragma once

#include "memory/dram_banks.h"
#include "memory/memory_cause.h"

#include <cstdint>

namespace ropsim {

// Sees every command as it is issued (in order, though not always at the wheel's present: an idle channel
// refreshes in arrears). For tests and command traces.
class DramCommandTrace {
 public:
    virtual ~DramCommandTrace() = default;
    // `bank` counts all banks of the channel; of a command to a rank it is the rank's first. `row`, `column`
    // are 0 where the command has none.
    virtual void command(DramCycle cycle, DramCommand command, std::uint32_t bank, std::uint32_t row,
                         std::uint32_t column) = 0;
};

// One request as the scheduler sees it: bytes [address, address + bytes).
struct DramRequest {
    std::uint64_t address = 0;
    std::uint32_t bytes = 0;
    bool write = false;
    bool masked = false;  // a write with disabled bytes: cannot serve a later read
    std::uint8_t surface = 0;
    MemoryCause cause = MemoryCause::kFill;
    std::uint32_t number = 0;  // of a read, < config.max_reads(); free again once in finished()
};

}  // namespace ropsim
