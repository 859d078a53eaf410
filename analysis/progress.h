// How far a list of runs has come, on stderr.
#pragma once

#include <cstddef>
#include <mutex>
#include <string>

namespace ropsim {

// A bar that redraws itself where stderr is a terminal, a line for each finished run elsewhere. Threads may
// share it.
class Progress {
 public:
    explicit Progress(std::size_t total);
    // `what` names the run that has ended; `failure` says why it failed, and stays on the terminal.
    void finished(const std::string& what, const std::string& failure = "");

 private:
    std::mutex mutex_;
    std::size_t total_;
    std::size_t done_ = 0;
    bool terminal_;
};

}  // namespace ropsim
