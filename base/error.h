// The two kinds of failure that are not a TLM response: the user's (UserError) and ours (CHECK).
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace ropsim {

// The user's input is at fault. `where` names the file, line, option or key; `what` says what is wrong and
// how to mend it. The program prints "where: what" as one line and exits with 1; both may quote a file or be
// a strange file's name, so control characters in them become spaces.
class UserError : public std::runtime_error {
 public:
    UserError(std::string where, std::string what);
    const std::string& where() const { return where_; }

 private:
    std::string where_;
};

// Prints the failed condition with its values to stderr and aborts.
[[noreturn]] void check_failed(const char* file, int line, const char* condition, const std::string& values);

}  // namespace ropsim

// Our own mistake: CHECK(condition) or CHECK(condition, "format {}", values...) aborts with the values.
#define CHECK(condition, ...)                                                                      \
    do {                                                                                           \
        if (!(condition)) [[unlikely]]                                                             \
            ::ropsim::check_failed(__FILE__, __LINE__, #condition, ::fmt::format("" __VA_ARGS__)); \
    } while (false)
