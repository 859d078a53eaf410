#include "model/interlock_config.h"

#include <string>

namespace ropsim {

namespace {

// A multiplexer is a select; a divider a reciprocal and its refinement; a random number a few rounds of an
// integer hash; a transcendental takes four issue slots, since special function units are a quarter as many
// as lanes. What waits for fetched bytes issues nothing.
constexpr std::array<int, kUnitCount> kInstructions = {1, 1, 8, 1, 1, 1, 1, 1, 1, 10, 1, 4, 0};

}  // namespace

InterlockConfig read_interlock(Parameters& p) {
    const auto count = [&p](const char* key, std::int64_t otherwise, std::int64_t most) {
        return static_cast<std::uint32_t>(p.get_integer(key, otherwise, 0, most));
    };
    InterlockConfig c;
    c.mode = p.get_choice("interlock.mode", "ordered", {"ordered", "spin"}) == "spin"
                 ? InterlockMode::kSpin
                 : InterlockMode::kOrdered;
    c.per_pixel = p.get_choice("interlock.granularity", "pixel", {"pixel", "quad"}) == "pixel";
    c.begin_cycles = count("interlock.begin_cycles", 20, 100000);
    c.end_cycles = count("interlock.end_cycles", 20, 100000);
    c.retry_cycles = count("interlock.retry_cycles", 20, 100000);
    c.memory_latency = count("interlock.memory_latency", 150, 100000);
    c.instruction_latency = count("interlock.instruction_latency", 4, 1000);
    c.overhead_instructions = count("interlock.overhead_instructions", 16, 100000);
    for (std::size_t u = 0; u < kInstructions.size(); ++u) {
        const std::string key = "interlock.instructions." + std::string(kUnitNames[u]);
        c.instructions[u] = count(key.c_str(), kInstructions[u], 1000);
    }
    return c;
}

}  // namespace ropsim
