// Files that no other test writes: tests run side by side, and a test's name may occur in several suites.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

namespace ropsim::test {

// A path of this process's own; whatever is there at the process's end is removed.
inline std::string own_file(const std::string& name) {
    struct Files {
        std::vector<std::string> paths;
        ~Files() {
            std::error_code ignored;
            for (const std::string& path : paths) std::filesystem::remove_all(path, ignored);
        }
    };
    static Files files;
    files.paths.push_back(::testing::TempDir() + "/ropsim_" + std::to_string(::getpid()) + "_" + name);
    return files.paths.back();
}

}  // namespace ropsim::test
