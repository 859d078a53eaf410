// A directory that goes away again.
#pragma once

#include <string>

namespace ropsim {

// Made where the system keeps temporary files, removed with everything in it by the destructor.
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
