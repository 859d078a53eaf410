// Runs the ropsim program as a child and keeps what it said.
#pragma once

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace ropsim {

struct ProgramResult {
    int status = -1;  // exit code; -1: ended by a signal
    int signal = 0;
    std::string out;
    std::string err;
};

namespace detail {
inline std::string content_of(std::FILE* file) {
    std::string text;
    std::rewind(file);
    std::array<char, 4096> piece;
    while (const std::size_t got = std::fread(piece.data(), 1, piece.size(), file))
        text.append(piece.data(), got);
    std::fclose(file);
    return text;
}

[[noreturn]] inline void become_program(const std::vector<std::string>& arguments, std::FILE* out,
                                        std::FILE* err) {
    ::dup2(::fileno(out), STDOUT_FILENO);
    ::dup2(::fileno(err), STDERR_FILENO);
    // A simulation that never ends must fail its test, not hang it.
    const rlimit seconds{100, 110};
    ::setrlimit(RLIMIT_CPU, &seconds);
    std::vector<char*> argv;
    std::string name = ROPSIM_PROGRAM;
    argv.push_back(name.data());
    std::vector<std::string> copies = arguments;
    for (std::string& a : copies) argv.push_back(a.data());
    argv.push_back(nullptr);
    ::execv(name.c_str(), argv.data());
    ::_exit(127);
}
}  // namespace detail

inline ProgramResult run_program(const std::vector<std::string>& arguments) {
    ProgramResult result;
    std::FILE* out = std::tmpfile();
    std::FILE* err = std::tmpfile();
    if (out == nullptr || err == nullptr) {
        ADD_FAILURE() << "no temporary file";
        return result;
    }
    const pid_t child = ::fork();
    if (child == 0) detail::become_program(arguments, out, err);
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFEXITED(status)) result.status = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
    result.out = detail::content_of(out);
    result.err = detail::content_of(err);
    return result;
}

// "a b c" for messages.
inline std::string spelled(const std::vector<std::string>& arguments) {
    std::string text = "ropsim";
    for (const std::string& a : arguments) text += " " + a;
    return text;
}

}  // namespace ropsim
