// What a process leaves that is interrupted or crashes.
#include "base/cleanup_on_signal.h"

#include "base/crash_remark.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>

#include <sys/wait.h>
#include <unistd.h>

namespace ropsim {
namespace {

// Temporaries a signal handler can remove: fixed storage, because a handler may neither allocate nor lock. A
// process has few files open for writing; those beyond the table are still removed by their destructor.
constexpr std::size_t kSlots = 64;
constexpr std::size_t kLongestPath = 1024;

enum SlotState : int { kFree, kFilling, kLive };

struct Slot {
    std::atomic<int> state{kFree};
    pid_t owner = 0;  // a forked child must not remove its parent's files
    std::array<char, kLongestPath> path{};
};

std::array<Slot, kSlots>& slots() {
    static std::array<Slot, kSlots> table;
    return table;
}

void say_on_stderr(std::string_view text) {
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
}

// unlink() refuses a directory, and a handler must not walk one. _Fork() is fork() without the locks that a
// handler must not wait for.
void remove_now(char* path) {
    if (::unlink(path) == 0 || errno != EISDIR) return;
    const pid_t child = ::_Fork();
    if (child == 0) {
        ::execl("/bin/rm", "rm", "-rf", "--", path, nullptr);
        ::_exit(1);
    }
    while (child > 0 && ::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
    }
}

void remove_all_and_die(int signal) {
    if (const char* remark = CrashRemark::current();
        remark != nullptr && signal != SIGINT && signal != SIGTERM) {
        say_on_stderr("ropsim: ");
        say_on_stderr(remark);
        say_on_stderr("\n");
    }
    for (Slot& slot : slots())
        if (slot.state.load() == kLive && slot.owner == ::getpid()) remove_now(slot.path.data());
    ::signal(signal, SIG_DFL);
    ::raise(signal);
}

}  // namespace

void remove_on_signal(const std::string& path) {
    if (path.size() >= kLongestPath) return;
    for (Slot& slot : slots()) {
        int expected = kFree;
        if (!slot.state.compare_exchange_strong(expected, kFilling)) continue;
        slot.owner = ::getpid();
        std::memcpy(slot.path.data(), path.c_str(), path.size() + 1);
        slot.state = kLive;
        return;
    }
}

void leave_on_signal(const std::string& path) {
    for (Slot& slot : slots()) {
        if (slot.state.load() == kLive && path == slot.path.data()) {
            slot.state = kFree;
            return;
        }
    }
}

void install_cleanup_on_signal() {
    slots();  // constructed now, not inside the handler
    struct sigaction action {};
    action.sa_handler = remove_all_and_die;
    sigemptyset(&action.sa_mask);
    for (const int signal : {SIGINT, SIGTERM, SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT}) {
        struct sigaction present {};
        sigaction(signal, nullptr, &present);
        // A sanitizer's own handler of a crash stays.
        const bool free = (present.sa_flags & SA_SIGINFO) == 0 && present.sa_handler == SIG_DFL;
        if (free || signal == SIGINT || signal == SIGTERM) sigaction(signal, &action, nullptr);
    }
}

}  // namespace ropsim
