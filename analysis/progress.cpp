// Bar or lines.
#include "analysis/progress.h"

#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace ropsim {

Progress::Progress(std::size_t total) : total_(total), terminal_(::isatty(STDERR_FILENO) == 1) {}

void Progress::finished(const std::string& what) {
    const std::scoped_lock lock(mutex_);
    ++done_;
    if (!terminal_) {
        fmt::print(stderr, "[{}/{}] {}\n", done_, total_, what);
        return;
    }
    constexpr std::size_t kWidth = 30;
    const std::size_t filled = kWidth * done_ / total_;
    fmt::print(stderr, "\r\033[K[{:#<{}}{:.<{}}] {}/{} {}", "", filled, "", kWidth - filled, done_, total_,
               what);
    if (done_ == total_) fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
}

}  // namespace ropsim
