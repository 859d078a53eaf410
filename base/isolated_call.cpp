// A child by fork, limits by setrlimit, the result through a pipe.
#include "base/isolated_call.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <string_view>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace ropsim {
namespace {

using Clock = std::chrono::steady_clock;

// What comes through the pipe first, then as many bytes; a child that sent less crashed.
enum Outcome : std::uint32_t { kDone, kUserError, kOtherError, kOutOfMemory };
struct Announcement {
    Outcome outcome = kDone;
    std::uint64_t bytes = 0;
};

#if defined(ROPSIM_SHADOW_MEMORY)
constexpr bool kLimitsAddressSpace = false;
#else
constexpr bool kLimitsAddressSpace = true;
#endif

std::uint64_t memory_limit(const IsolationLimits& limits) {
    const auto pages = static_cast<std::uint64_t>(std::max(::sysconf(_SC_PHYS_PAGES), 1L));
    const auto page = static_cast<std::uint64_t>(std::max(::sysconf(_SC_PAGESIZE), 1L));
    return std::min(limits.memory_bytes, pages * page / 2);
}

void limit(int resource, std::uint64_t value) {
    // Past the first limit a process is told, past the second killed. One that cannot be had leaves the
    // parent's: no reason not to read the file.
    const rlimit pair{value, value + (resource == RLIMIT_CPU ? 1 : 0)};
    ::setrlimit(static_cast<__rlimit_resource>(resource), &pair);
}

void write_all(int file, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(file, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return;
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
}

[[noreturn]] void run_child(int result, const IsolationLimits& limits,
                            const std::function<std::string()>& work) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC); nowhere >= 0) {
        // A reader that aborts says so on stderr; the user gets one line from the parent instead.
        for (int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, file);
    }
    // A crash ends the child and nothing else: no handler of the parent's, who may want to write a report.
    for (int signal = 1; signal < NSIG; ++signal) ::signal(signal, SIG_DFL);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, static_cast<std::uint64_t>(limits.cpu_seconds));
    if (kLimitsAddressSpace) limit(RLIMIT_AS, memory_limit(limits));
    Outcome outcome = kDone;
    std::string bytes;
    try {
        bytes = work();
    } catch (const UserError& error) {
        outcome = kUserError;
        bytes = error.where() + '\0' + error.what();
    } catch (const std::bad_alloc&) {
        outcome = kOutOfMemory;
    } catch (const std::exception& error) {
        outcome = kOtherError;
        bytes = error.what();
    } catch (...) {
        outcome = kOtherError;
        bytes = "unknown exception";
    }
    const Announcement announcement{outcome, bytes.size()};
    write_all(result, {reinterpret_cast<const char*>(&announcement), sizeof announcement});
    write_all(result, bytes);
    ::_exit(0);
}

// All that comes through `file` until its other end closes; nothing if that takes longer than allowed.
std::optional<std::string> read_until(int file, Clock::time_point deadline) {
    std::string bytes;
    std::array<char, 65536> piece;
    for (;;) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
        pollfd waiting{file, POLLIN, 0};
        const int ready = left <= 0 ? 0 : ::poll(&waiting, 1, static_cast<int>(left));
        if (ready == 0) return std::nullopt;
        if (ready < 0) continue;  // interrupted
        const ssize_t size = ::read(file, piece.data(), piece.size());
        if (size == 0) return bytes;
        if (size > 0) bytes.append(piece.data(), static_cast<std::size_t>(size));
    }
}

// Why there is no result, as a UserError.
[[noreturn]] void report_failure(const std::string& where, const IsolationLimits& limits, Outcome outcome,
                                 std::string message) {
    if (outcome == kUserError) {
        const std::size_t end = message.find('\0');
        throw UserError(message.substr(0, end), message.substr(end + 1));
    }
    if (outcome == kOutOfMemory) {
        throw UserError(
            where, fmt::format("reading it needs more than {} MiB of memory; it is malformed or too large",
                               memory_limit(limits) >> 20));
    }
    throw UserError(where, fmt::format("its reader failed ({}); the file is malformed", message));
}

[[noreturn]] void report_crash(const std::string& where, int status) {
    const std::string how =
        WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status)) : fmt::format("exit {}", WEXITSTATUS(status));
    throw UserError(where, fmt::format("its reader crashed ({}); the file is malformed", how));
}

}  // namespace

std::string call_isolated(const std::string& where, const IsolationLimits& limits,
                          const std::function<std::string()>& work) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        throw UserError(where, fmt::format("cannot make a pipe to its reader ({})", std::strerror(errno)));
    const auto deadline = Clock::now() + std::chrono::seconds(limits.wait_seconds);
    const pid_t child = ::fork();
    if (child == 0) {
        ::close(ends[0]);
        run_child(ends[1], limits, work);
    }
    const int fault = errno;
    ::close(ends[1]);
    if (child < 0) {
        ::close(ends[0]);
        throw UserError(where, fmt::format("cannot start its reader ({})", std::strerror(fault)));
    }
    std::optional<std::string> result;
    std::exception_ptr trouble;
    try {
        result = read_until(ends[0], deadline);
    } catch (...) {
        trouble = std::current_exception();  // no memory for the result: the child must not stay
    }
    ::close(ends[0]);
    // Closing the pipe leaves a child that still writes or hangs to this.
    if (!result) ::kill(child, SIGKILL);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (trouble) std::rethrow_exception(trouble);
    const bool spent = WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU;
    if (!result || spent) {
        throw UserError(where, fmt::format("reading it takes longer than {} s; it is malformed or too large",
                                           spent ? limits.cpu_seconds : limits.wait_seconds));
    }
    Announcement announcement;
    if (result->size() < sizeof announcement) report_crash(where, status);
    std::memcpy(&announcement, result->data(), sizeof announcement);
    result->erase(0, sizeof announcement);
    if (result->size() != announcement.bytes) report_crash(where, status);
    if (announcement.outcome != kDone)
        report_failure(where, limits, announcement.outcome, *std::move(result));
    return *std::move(result);
}

}  // namespace ropsim
