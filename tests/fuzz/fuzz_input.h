// What every fuzz target needs: its input as a file, and the rule that faults of the input are UserErrors.
#pragma once

#include "base/error.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace ropsim::fuzz {

// The input as a file in memory, for readers that want a path.
class InputFile {
 public:
    InputFile(const std::uint8_t* data, std::size_t size);
    ~InputFile();
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;
    const std::string& path() const { return path_; }

 private:
    int descriptor_;
    std::string path_;
};

// A path in a directory that goes when the process ends; the same name gives the same path.
std::string scratch_path(const std::string& name);

// Reads a trace from end to end, twice, and holds what comes out against what the header and the index
// promise; a difference aborts. Throws UserError as the reader does.
void read_whole_trace(const std::string& path);

// Whether `read` ends without a UserError; every other exception ends the process, which is a finding.
template <typename Read>
bool accepted(Read read) noexcept {
    try {
        read();
        return true;
    } catch (const UserError& error) {
        CHECK(!error.where().empty() && (error.where() + error.what()).find('\n') == std::string::npos,
              "{}: {}", error.where(), error.what());
        return false;
    }
}

}  // namespace ropsim::fuzz
