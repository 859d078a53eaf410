// Files that appear under their final name only when they are complete.
#include "base/atomic_file.h"

#include "base/crash_remark.h"
#include "base/error.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>

#include <fcntl.h>
#include <sys/stat.h>
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

void remember(const std::string& path) {
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

void forget(const std::string& path) {
    for (Slot& slot : slots()) {
        if (slot.state.load() == kLive && path == slot.path.data()) {
            slot.state = kFree;
            return;
        }
    }
}

void say_on_stderr(std::string_view text) {
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
}

void remove_all_and_die(int signal) {
    if (const char* remark = CrashRemark::current();
        remark != nullptr && signal != SIGINT && signal != SIGTERM) {
        say_on_stderr("ropsim: ");
        say_on_stderr(remark);
        say_on_stderr("\n");
    }
    for (Slot& slot : slots())
        if (slot.state.load() == kLive && slot.owner == ::getpid()) ::unlink(slot.path.data());
    ::signal(signal, SIG_DFL);
    ::raise(signal);
}

std::string reason() {
    return std::strerror(errno);
}

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, CloseFile>;

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
    static std::atomic<unsigned> serial{0};
    struct stat status {};
    if (path_.empty()) throw UserError("output file", "the name is empty; give a path");
    // Renaming over a directory fails late; renaming over a device such as /dev/null would replace the
    // device.
    if (::stat(path_.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
        throw UserError(path_, "exists and is not a regular file; choose another name");
    temporary_ = fmt::format("{}.partial-{}-{}", path_, ::getpid(), serial++);
    const int file = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) {
        const std::string why = reason();
        throw UserError(path_, fmt::format("cannot create a file there ({}); check the directory", why));
    }
    ::close(file);
    remember(temporary_);
}

AtomicFile::~AtomicFile() {
    if (committed_) return;
    ::unlink(temporary_.c_str());
    forget(temporary_);
}

void AtomicFile::commit() {
    CHECK(!committed_, "{}", path_);
    // Without the flush a crash of the machine could leave the name pointing at an empty file.
    const int file = ::open(temporary_.c_str(), O_RDONLY | O_CLOEXEC);
    const bool flushed = file >= 0 && ::fsync(file) == 0;
    const std::string why = reason();
    if (file >= 0) ::close(file);
    if (!flushed) throw UserError(path_, fmt::format("cannot write ({}); check the disk", why));
    if (::rename(temporary_.c_str(), path_.c_str()) != 0)
        throw UserError(path_, fmt::format("cannot put the finished file in place ({})", reason()));
    committed_ = true;
    forget(temporary_);
}

void write_file(const std::string& path, std::string_view content) {
    AtomicFile file(path);
    FileHandle out(std::fopen(file.temporary_path().c_str(), "wb"));
    const bool written = out && std::fwrite(content.data(), 1, content.size(), out.get()) == content.size() &&
                         std::fflush(out.get()) == 0;
    if (!written) throw UserError(path, fmt::format("cannot write ({}); check the disk", reason()));
    out.reset();
    file.commit();
}

std::string read_file(const std::string& path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) throw UserError(path, "is a directory; a file is wanted");
    FileHandle in(std::fopen(path.c_str(), "rb"));
    if (!in) throw UserError(path, fmt::format("cannot open ({})", reason()));
    std::string content;
    std::array<char, 65536> piece;
    while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), in.get()))
        content.append(piece.data(), size);
    if (std::ferror(in.get())) throw UserError(path, fmt::format("cannot read ({})", reason()));
    return content;
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
