// Calls code that is not ours and may crash, hang or eat memory, without harm to this process.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace ropsim {

struct IsolationLimits {
    std::uint64_t memory_bytes = std::uint64_t{4} << 30;  // address space; at most half of the machine's
                                                          // memory. Not enforced in a sanitizer build
    int cpu_seconds = 60;                                 // of processor time
    int wait_seconds = 600;                               // until it is done, whatever else the machine does
};

// Runs `work` in a forked process and returns what it returns. A UserError that it throws is thrown here. A
// crash, a call of exit, an overstepped limit or any other exception is a UserError about `where` (the file
// that was being read) that says which. The process gets a copy of this one's memory as it stands, sees no
// terminal, and ends without running destructors of globals: `work` must leave nothing behind but its result.
// Call it while no other thread holds a lock that `work` wants, best before there are any (drivers of OpenGL
// make some).
std::string call_isolated(const std::string& where, const IsolationLimits& limits,
                          const std::function<std::string()>& work);

}  // namespace ropsim
