// A directory that goes away again.
#pragma once

#include <string>

namespace ropsim {

// Made where the system keeps temporary files, removed with everything in it by the destructor, or
// when the process is interrupted (cleanup_on_signal.h).
class TemporaryDirectory {
 public:
    TemporaryDirectory();
    ~TemporaryDirectory();
    TemporaryDirectory(const TemporaryDirectory&) = delete;
    TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
    const std::string& path() const { return path_; }

 private:
    std::string path_;
};

}  // namespace ropsim
