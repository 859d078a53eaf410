#include "base/error.h"

#include "base/crash_remark.h"

#include <cstdio>
#include <cstdlib>

namespace ropsim {
namespace {

std::string on_one_line(std::string text) {
    constexpr unsigned char kDelete = 0x7F;
    for (char& c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < ' ' || byte == kDelete) c = ' ';
    }
    return text;
}

// A file without a name, to be seen in the message.
std::string named(const std::string& where) {
    return where.empty() ? "''" : where;
}

}  // namespace

UserError::UserError(std::string where, std::string what)
    : std::runtime_error(on_one_line(std::move(what))), where_(named(on_one_line(std::move(where)))) {}

void check_failed(const char* file, int line, const char* condition, const std::string& values) {
    std::fprintf(stderr, "ropsim: internal error at %s:%d: %s%s%s\n", file, line, condition,
                 values.empty() ? "" : ": ", values.c_str());
    CrashRemark::forget();
    std::abort();
}

}  // namespace ropsim
