// A temporary directory is there, its own, and goes away with what is in it.
#include "base/temporary_directory.h"

#include "base/atomic_file.h"
#include "base/cleanup_on_signal.h"
#include "base/error.h"

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

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

TEST(TemporaryDirectory, InterruptedGoesAwayWithItsFiles) {
    std::array<int, 2> name{};
    ASSERT_EQ(::pipe(name.data()), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        install_cleanup_on_signal();
        const TemporaryDirectory directory;
        fs::create_directory(directory.path() + "/runs");
        write_file(directory.path() + "/runs/file", "text");
        const auto written = ::write(name[1], directory.path().data(), directory.path().size());
        ::raise(SIGINT);
        ::_exit(written < 0 ? 1 : 0);
    }
    ::close(name[1]);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
    std::array<char, 256> path{};
    ASSERT_GT(::read(name[0], path.data(), path.size() - 1), 0);
    EXPECT_FALSE(fs::exists(path.data())) << path.data();
}

TEST(TemporaryDirectory, NamesTheVariableThatSaysWhere) {
    ::setenv("TMPDIR", "/nonexistent", 1);
    EXPECT_THROW(TemporaryDirectory(), UserError);
    ::unsetenv("TMPDIR");
}

}  // namespace
}  // namespace ropsim
