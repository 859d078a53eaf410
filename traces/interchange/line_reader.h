// Reads a text file line by line without copying.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

class LineReader {
 public:
    static constexpr std::size_t kLongestLine = 1u << 16;

    // Throws UserError where there is no such file.
    explicit LineReader(const std::string& path);
    // The next line without its end and without blanks around it; valid until the next call. False at the
    // end. Throws UserError on a line of more than 2^16 bytes: the file is no text then.
    bool next(std::string_view& line);
    // "FILE:LINE" of the last line, for messages.
    std::string place() const;
    std::uint64_t number() const { return number_; }

 private:
    bool refill();

    struct CloseFile {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    std::string path_;
    std::unique_ptr<std::FILE, CloseFile> in_;
    std::vector<char> buffer_;
    std::size_t begin_ = 0, end_ = 0;  // what is not consumed yet
    std::uint64_t number_ = 0;
};

// `text` without blanks, tabs and carriage returns around it.
inline std::string_view trimmed(std::string_view text) {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

}  // namespace ropsim
