// posix_spawn, a pipe for stderr, waitpid.
#include "analysis/child_process.h"

#include "base/error.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace ropsim {
namespace {

constexpr std::size_t kKeptBytes = 64 << 10;

class SpawnActions {
 public:
    SpawnActions() { CHECK(posix_spawn_file_actions_init(&actions_) == 0); }
    ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
    SpawnActions(const SpawnActions&) = delete;
    SpawnActions& operator=(const SpawnActions&) = delete;
    void open_null(int descriptor, int mode) {
        CHECK(posix_spawn_file_actions_addopen(&actions_, descriptor, "/dev/null", mode, 0) == 0);
    }
    void duplicate(int from, int to) { CHECK(posix_spawn_file_actions_adddup2(&actions_, from, to) == 0); }
    const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
    posix_spawn_file_actions_t actions_{};
};

std::string read_all(int descriptor) {
    std::string text;
    std::array<char, 4096> buffer{};
    for (;;) {
        const ssize_t count = ::read(descriptor, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return text;
        text.append(buffer.data(), static_cast<std::size_t>(count));
        if (text.size() > 2 * kKeptBytes) text.erase(0, text.size() - kKeptBytes);
    }
}

std::string last_line(const std::string& text) {
    const std::size_t end = text.find_last_not_of(" \t\r\n");
    if (end == std::string::npos) return {};
    const std::size_t start = text.find_last_of("\r\n", end);
    std::string line = text.substr(start == std::string::npos ? 0 : start + 1,
                                   end - (start == std::string::npos ? 0 : start + 1) + 1);
    constexpr std::string_view kOwnPrefix = "ropsim: ";
    if (line.starts_with(kOwnPrefix)) line.erase(0, kOwnPrefix.size());
    return line;
}

}  // namespace

std::string ChildResult::failure() const {
    if (exit_code == 0) return {};
    const std::string said = last_line(error_output);
    if (signal != 0) {
        const std::string ended = fmt::format("ended by signal {} ({})", signal, strsignal(signal));
        return said.empty() ? ended : fmt::format("{}: {}", ended, said);
    }
    return said.empty() ? fmt::format("exit code {}", exit_code) : said;
}

ChildResult run_child(const std::vector<std::string>& arguments) {
    CHECK(!arguments.empty());
    std::array<int, 2> ends{};
    // Close-on-exec: children started by other threads must not hold this pipe open.
    CHECK(::pipe2(ends.data(), O_CLOEXEC) == 0, "pipe2: {}", std::strerror(errno));
    SpawnActions actions;
    actions.open_null(STDIN_FILENO, O_RDONLY);
    actions.open_null(STDOUT_FILENO, O_WRONLY);
    actions.duplicate(ends[1], STDERR_FILENO);
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    pid_t child = -1;
    const int error = ::posix_spawn(&child, argv[0], actions.get(), nullptr, argv.data(), environ);
    ::close(ends[1]);
    if (error != 0) {
        ::close(ends[0]);
        throw UserError(arguments[0], fmt::format("cannot be started: {}", std::strerror(error)));
    }
    ChildResult result;
    result.error_output = read_all(ends[0]);
    ::close(ends[0]);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0) CHECK(errno == EINTR, "waitpid: {}", std::strerror(errno));
    if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
    if (result.error_output.size() > kKeptBytes)
        result.error_output.erase(0, result.error_output.size() - kKeptBytes);
    return result;
}

std::string own_program_path() {
    return std::filesystem::read_symlink("/proc/self/exe").string();
}

std::string shell_line(const std::vector<std::string>& arguments) {
    constexpr std::string_view kPlain =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_@%+=:,./-";
    std::string line;
    for (const std::string& argument : arguments) {
        if (!line.empty()) line += ' ';
        if (!argument.empty() && argument.find_first_not_of(kPlain) == std::string::npos) {
            line += argument;
            continue;
        }
        line += '\'';
        for (const char c : argument) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
        line += '\'';
    }
    return line;
}

}  // namespace ropsim
