// Small traces at the edges of what fragments can be, each for a reason of its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

struct StressTrace {
    const char* name;     // lower_snake
    const char* summary;  // what it holds and what it is for, one line
};

const std::vector<StressTrace>& stress_traces();

// Writes one of them. The same name and seed give the same bytes. Throws UserError on an unknown name.
void write_stress_trace(const std::string& name, const std::string& path, std::uint64_t seed = 0);

}  // namespace ropsim
