// A scratch directory for one test, removed at its end.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

namespace ropsim {

class ScratchTest : public ::testing::Test {
 protected:
    void SetUp() override { std::filesystem::create_directory(directory_); }
    void TearDown() override { std::filesystem::remove_all(directory_); }
    std::string path(const std::string& name) const { return (directory_ / name).string(); }
    std::size_t entries() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(directory_),
                                                      std::filesystem::directory_iterator()));
    }

 private:
    std::filesystem::path directory_ =
        std::filesystem::temp_directory_path() / ("ropsim_traces_" + std::to_string(::getpid()));
};

}  // namespace ropsim
