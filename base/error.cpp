#include "base/error.h"

#include <cstdio>
#include <cstdlib>

namespace ropsim {

void check_failed(const char* file, int line, const char* condition, const std::string& values) {
    std::fprintf(stderr, "ropsim: internal error at %s:%d: %s%s%s\n", file, line, condition,
                 values.empty() ? "" : ": ", values.c_str());
    std::abort();
}

}  // namespace ropsim
