// Whatever the isolated code does, this process lives and says what happened.
#include "base/isolated_call.h"

#include "base/error.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

constexpr IsolationLimits kLimits{std::uint64_t{1} << 30, 30, 60};

// The error that `work` ends in, "" without.
std::string fault(const std::function<std::string()>& work, const IsolationLimits& limits = kLimits) {
    try {
        call_isolated("the file", limits, work);
    } catch (const UserError& error) {
        EXPECT_EQ(error.what(), std::string(error.what()).substr(0, std::string(error.what()).find('\n')));
        return error.where() + ": " + error.what();
    }
    return "";
}

TEST(IsolatedCallTest, ReturnsWhatTheWorkReturns) {
    EXPECT_EQ(call_isolated("x", kLimits, [] { return std::string("a\0b\n", 4); }), std::string("a\0b\n", 4));
    EXPECT_EQ(call_isolated("x", kLimits, [] { return std::string(); }), "");
    // Far more than a pipe holds.
    std::string large(5'000'000, '\0');
    for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(i * i >> 7);
    EXPECT_EQ(call_isolated("x", kLimits, [&] { return large; }), large);
}

TEST(IsolatedCallTest, RunsInAProcessOfItsOwn) {
    int value = 1;
    const std::string child = call_isolated("x", kLimits, [&] {
        value = 2;
        return std::to_string(::getpid());
    });
    EXPECT_NE(child, std::to_string(::getpid()));
    EXPECT_EQ(value, 1);
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "no child is left";
}

TEST(IsolatedCallTest, UserErrorsComeThrough) {
    EXPECT_EQ(fault([]() -> std::string { throw UserError("line 7", "is bad; mend it"); }),
              "line 7: is bad; mend it");
}

TEST(IsolatedCallTest, OtherEndsAreErrorsAboutTheFile) {
    EXPECT_EQ(fault([]() -> std::string { throw std::runtime_error("no\nway"); }),
              "the file: its reader failed (no way); the file is malformed");
    EXPECT_EQ(fault([]() -> std::string { throw 1; }),
              "the file: its reader failed (unknown exception); the file is malformed");
    EXPECT_EQ(fault([]() -> std::string { throw std::bad_alloc(); }),
              "the file: reading it needs more than 1024 MiB of memory; it is malformed or too large");
    EXPECT_EQ(fault([]() -> std::string { ::_exit(0); }),
              "the file: its reader crashed (exit 0); the file is malformed");
    EXPECT_EQ(fault([]() -> std::string { ::_exit(3); }),
              "the file: its reader crashed (exit 3); the file is malformed");
    EXPECT_EQ(fault([]() -> std::string {
                  ::raise(SIGKILL);
                  return "";
              }),
              "the file: its reader crashed (Killed); the file is malformed");
    EXPECT_THAT(fault([]() -> std::string {
                    ::signal(SIGABRT, SIG_DFL);
                    std::abort();
                }),
                HasSubstr("its reader crashed"));
}

TEST(IsolatedCallTest, SleepersAndSpinnersAreEnded) {
    EXPECT_THAT(fault(
                    []() -> std::string {
                        for (;;) ::pause();
                    },
                    {std::uint64_t{1} << 30, 30, 1}),
                HasSubstr("longer than 1 s"));
    EXPECT_THAT(fault(
                    []() -> std::string {
                        for (std::atomic<unsigned> i{0};;) ++i;
                    },
                    {std::uint64_t{1} << 30, 1, 60}),
                HasSubstr("longer than 1 s"));
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "no child is left";
}

TEST(IsolatedCallTest, NeedsNoNewsOfItsChildrenFromTheSystem) {
    // As inherited from a parent that ignores the signal: then no exit status can be had.
    ::signal(SIGCHLD, SIG_IGN);
    EXPECT_EQ(call_isolated("x", kLimits, [] { return std::string("result"); }), "result");
    EXPECT_EQ(fault([]() -> std::string { throw UserError("line 7", "is bad"); }), "line 7: is bad");
    EXPECT_THAT(fault([]() -> std::string { ::_exit(0); }), HasSubstr("its reader crashed"));
    ::signal(SIGCHLD, SIG_DFL);
}

TEST(IsolatedCallTest, MemoryIsLimited) {
#if defined(ROPSIM_SHADOW_MEMORY)
    GTEST_SKIP() << "a sanitizer maps more than any limit";
#endif
    EXPECT_THAT(fault([]() -> std::string {
                    std::vector<std::string> pieces;
                    for (;;) pieces.emplace_back(std::size_t{1} << 24, 'x');
                }),
                HasSubstr("more than 1024 MiB of memory"));
}

}  // namespace
}  // namespace ropsim
