// A temporary directory is there, its own, and goes away with what is in it.
#include "base/temporary_directory.h"

#include "base/atomic_file.h"
#include "base/error.h"

#include <cstdlib>
#include <filesystem>
#include <optional>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

namespace fs = std::filesystem;

TEST(TemporaryDirectory, GoesAwayWithItsFiles) {
    std::optional<TemporaryDirectory> one(std::in_place);
    const TemporaryDirectory other;
    const std::string path = one->path();
    EXPECT_NE(path, other.path());
    ASSERT_TRUE(fs::is_directory(path));
    fs::create_directory(path + "/runs");
    write_file(path + "/runs/file", "text");
    one.reset();
    EXPECT_FALSE(fs::exists(path));
    EXPECT_TRUE(fs::is_directory(other.path()));
}

TEST(TemporaryDirectory, NamesTheVariableThatSaysWhere) {
    ::setenv("TMPDIR", "/nonexistent", 1);
    EXPECT_THROW(TemporaryDirectory(), UserError);
    ::unsetenv("TMPDIR");
}

}  // namespace
}  // namespace ropsim
