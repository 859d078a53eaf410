// AtomicFile: nothing half-written under the final name.
#include "base/atomic_file.h"

#include "base/cleanup_on_signal.h"
#include "base/error.h"

#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace ropsim {
namespace {

namespace fs = std::filesystem;

// A directory of its own, removed at the end.
class AtomicFileTest : public ::testing::Test {
 protected:
    void SetUp() override { fs::create_directory(directory_); }
    void TearDown() override { fs::remove_all(directory_); }
    std::string path(const std::string& name) const { return (directory_ / name).string(); }
    std::size_t entries() const {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(directory_), fs::directory_iterator()));
    }
    fs::path directory_ = fs::temp_directory_path() / fmt::format("ropsim_atomic_{}", ::getpid());
};

TEST_F(AtomicFileTest, WritesAndReadsBackEveryByte) {
    const std::string content("a\0b\r\n\xff", 6);
    write_file(path("f"), content);
    EXPECT_EQ(read_file(path("f")), content);
    EXPECT_EQ(entries(), 1u);
}

TEST_F(AtomicFileTest, UncommittedLeavesTheOldFileAndNoTemporary) {
    write_file(path("f"), "old");
    {
        AtomicFile file(path("f"));
        EXPECT_EQ(entries(), 2u);
    }
    EXPECT_EQ(read_file(path("f")), "old");
    EXPECT_EQ(entries(), 1u);
}

TEST_F(AtomicFileTest, CommitReplaces) {
    write_file(path("f"), "old");
    write_file(path("f"), "new");
    EXPECT_EQ(read_file(path("f")), "new");
}

TEST_F(AtomicFileTest, RefusesWhatCannotBeAFile) {
    EXPECT_THROW(AtomicFile(path("missing/f")), UserError);
    EXPECT_THROW(AtomicFile(directory_.string()), UserError);
    EXPECT_THROW(AtomicFile("/dev/null"), UserError);
    EXPECT_THROW(AtomicFile(""), UserError);
    EXPECT_THROW(read_file(path("missing")), UserError);
    EXPECT_THROW(read_file(directory_.string()), UserError);
}

TEST_F(AtomicFileTest, SignalRemovesTemporaries) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        install_cleanup_on_signal();
        const AtomicFile file(path("f"));
        ::raise(SIGTERM);
        ::_exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status));
    EXPECT_EQ(WTERMSIG(status), SIGTERM);
    EXPECT_EQ(entries(), 0u);
}

TEST_F(AtomicFileTest, ChildsSignalLeavesTheParentsFile) {
    install_cleanup_on_signal();
    const AtomicFile file(path("f"));
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        ::raise(SIGTERM);
        ::_exit(0);
    }
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    EXPECT_TRUE(fs::exists(file.temporary_path()));
}

}  // namespace
}  // namespace ropsim
