// Runs a program as a child process and keeps what it says on stderr.
#pragma once

#include <string>
#include <vector>

namespace ropsim {

struct ChildResult {
    int exit_code = -1;        // -1: ended by a signal
    int signal = 0;            // 0: ended by itself
    std::string error_output;  // the last 64 KiB of stderr
    // One line that says why the child failed: the last line of its stderr, or how it ended. Empty on
    // success.
    std::string failure() const;
};

// arguments[0] is the program's path. stdin and stdout are /dev/null. Blocks until the child has ended; may
// be called from several threads at once. Throws UserError when the program cannot be started.
ChildResult run_child(const std::vector<std::string>& arguments);

// Absolute path of the running program.
std::string own_program_path();

// The arguments as one line that a POSIX shell reads back as the same arguments.
std::string shell_line(const std::vector<std::string>& arguments);

}  // namespace ropsim
