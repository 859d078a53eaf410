// Bar or lines.
#include "analysis/progress.h"

#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace ropsim {

Progress::Progress(std::size_t total) : total_(total), terminal_(::isatty(STDERR_FILENO) == 1) {}

void Progress::finished(const std::string& what, const std::string& failure) {
    const std::scoped_lock lock(mutex_);
    ++done_;
    const std::string line = failure.empty() ? what : fmt::format("{} failed: {}", what, failure);
    if (!terminal_) {
        fmt::print(stderr, "[{}/{}] {}\n", done_, total_, line);
        return;
    }
    if (!failure.empty()) fmt::print(stderr, "\r\033[K{}\n", line);
    constexpr std::size_t kWidth = 30;
    const std::size_t filled = kWidth * done_ / total_;
    fmt::print(stderr, "\r\033[K[{:#<{}}{:.<{}}] {}/{} {}", "", filled, "", kWidth - filled, done_, total_,
               what);
    if (done_ == total_) fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
}

}  // namespace ropsim
