// What a process leaves that is interrupted or crashes.
#pragma once

#include <string>

namespace ropsim {

// From now on a process that is interrupted or crashes first removes what is registered below.
void install_cleanup_on_signal();

// A file or a directory with all that is in it, until leave_on_signal(). Paths beyond the 64 that are kept at
// a time, or of 1024 characters and more, are not removed. A forked child does not remove its parent's.
void remove_on_signal(const std::string& path);
void leave_on_signal(const std::string& path);

}  // namespace ropsim
