# A third of the time to compile the project goes to these headers. Every source still includes what it uses:
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON builds too.
function(ropsim_precompile target)
  target_precompile_headers(${target} PRIVATE <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <map>
    <memory> <optional> <set> <span> <string> <vector> <fmt/format.h> ${ARGN})
endfunction()
