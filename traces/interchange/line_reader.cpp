// Reads a text file line by line without copying.
#include "traces/interchange/line_reader.h"

#include "base/error.h"

#include <cstring>
#include <filesystem>

namespace ropsim {

namespace {
constexpr std::size_t kBuffer = 1u << 20;
}

LineReader::LineReader(const std::string& path) : path_(path), buffer_(kBuffer) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        throw UserError(path, "no such file; give a CSV file");
    in_.reset(std::fopen(path.c_str(), "rb"));
    if (!in_) throw UserError(path, "cannot open; check its permissions");
}

std::string LineReader::place() const {
    return fmt::format("{}:{}", path_, number_);
}

// Moves what is left to the front and reads on; false at the end of the file.
bool LineReader::refill() {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    const std::size_t got = std::fread(buffer_.data() + end_, 1, buffer_.size() - end_, in_.get());
    if (got == 0 && std::ferror(in_.get()) != 0) throw UserError(place(), "cannot be read further");
    end_ += got;
    return got != 0;
}

bool LineReader::next(std::string_view& line) {
    for (;;) {
        const char* const start = buffer_.data() + begin_;
        const std::size_t left = end_ - begin_;
        const void* found = left == 0 ? nullptr : std::memchr(start, '\n', left);
        const std::size_t length =
            found != nullptr ? static_cast<std::size_t>(static_cast<const char*>(found) - start) : left;
        if (length > kLongestLine) {
            ++number_;
            throw UserError(place(), "a line of more than 65536 bytes; this is no CSV file of fragments");
        }
        if (found == nullptr && refill()) continue;
        if (found == nullptr && left == 0) return false;
        ++number_;
        line = trimmed({buffer_.data() + begin_, length});
        begin_ += length + (found != nullptr ? 1 : 0);
        return true;
    }
}

}  // namespace ropsim
