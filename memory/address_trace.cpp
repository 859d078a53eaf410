// Reading and writing of address traces.
#include "memory/address_trace.h"

#include "base/error.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <iterator>

#include <sys/stat.h>

namespace ropsim {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 18;  // bytes read at once
constexpr std::size_t kMaxLine = 1000;

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

std::uint64_t count_lines(std::string_view text) {
    return static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n'));
}

// One line, with the place that messages name.
class LineParser {
 public:
    LineParser(std::string_view line, const std::string& path, std::uint64_t number)
        : line_(line), at_(line.data()), end_(line.data() + line.size()), path_(path), number_(number) {}

    // False: the line holds no request.
    bool parse(AddressRequest& request) {
        skip_blanks();
        if (at_ == end_ || *at_ == '#') return false;
        request.address = address();
        request.write = command();
        request.cycle = cycle();
        skip_blanks();
        if (at_ != end_) fail(fmt::format("'{}' after the cycle", word()));
        return true;
    }

 private:
    void skip_blanks() {
        while (at_ != end_ && is_blank(*at_)) ++at_;
    }
    std::string_view word() {
        skip_blanks();
        const char* const from = at_;
        while (at_ != end_ && !is_blank(*at_)) ++at_;
        return {from, static_cast<std::size_t>(std::min<std::ptrdiff_t>(at_ - from, 40))};
    }
    std::uint64_t address() {
        const std::string_view text = word();
        std::uint64_t value = 0;
        const bool prefixed = text.size() > 2 && text[0] == '0' && (text[1] | 0x20) == 'x';
        if (!prefixed || !number(text.substr(2), 16, value))
            fail(fmt::format("'{}' is no address such as 0x1f40", text));
        return value;
    }
    bool command() {
        const std::string_view text = word();
        if (equal(text, "read")) return false;
        if (!equal(text, "write"))
            fail(text.empty() ? std::string("READ or WRITE is missing after the address")
                              : fmt::format("'{}' is neither READ nor WRITE", text));
        return true;
    }
    std::uint64_t cycle() {
        const std::string_view text = word();
        std::uint64_t value = 0;
        if (text.empty()) fail("the cycle of arrival is missing");
        if (!number(text, 10, value) || value >> 48 != 0)
            fail(fmt::format("'{}' is no cycle from 0 to 2^48 - 1", text));
        return value;
    }
    static bool number(std::string_view text, int base, std::uint64_t& value) {
        const char* const end = text.data() + text.size();
        const auto result = std::from_chars(text.data(), end, value, base);
        return result.ec == std::errc() && result.ptr == end;
    }
    static bool equal(std::string_view text, std::string_view lower) {
        return text.size() == lower.size() && std::equal(text.begin(), text.end(), lower.begin(),
                                                         [](char a, char b) { return (a | 0x20) == b; });
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw UserError(fmt::format("{}:{}", path_, number_),
                        what + "; a line is '0xADDRESS READ|WRITE CYCLE'");
    }

    std::string_view line_;
    const char* at_;
    const char* end_;
    const std::string& path_;
    std::uint64_t number_;
};

}  // namespace

AddressTraceReader::AddressTraceReader(std::string path) : path_(std::move(path)) {
    struct stat status {};
    file_.reset(std::fopen(path_.c_str(), "rb"));
    if (file_ != nullptr && ::fstat(::fileno(file_.get()), &status) == 0 && S_ISDIR(status.st_mode))
        throw UserError(path_, "is a directory, not an address trace");
    if (file_ == nullptr) throw UserError(path_, fmt::format("cannot be read: {}", std::strerror(errno)));
    buffer_.resize(kMaxLine + kBlock);
}

// Reads on behind the unfinished line that is kept. Returns how many bytes of whole lines there are now.
std::size_t AddressTraceReader::refill() {
    const std::size_t got = std::fread(buffer_.data() + held_, 1, kBlock, file_.get());
    if (got == 0 && std::ferror(file_.get()) != 0)
        throw UserError(path_, fmt::format("cannot be read: {}", std::strerror(errno)));
    if (line_ == 0 && held_ == 0 && got >= 2 && buffer_[0] == '\x1f' && buffer_[1] == '\x8b')
        throw UserError(path_, fmt::format("is compressed; use: zcat {} | ropsim memory /dev/stdin", path_));
    held_ += got;
    ended_ = got == 0;
    const std::string_view text(buffer_.data(), held_);
    const std::size_t whole = ended_ ? held_ : text.rfind('\n') + 1;
    if (held_ - whole > kMaxLine)
        throw UserError(fmt::format("{}:{}", path_, line_ + 1 + count_lines(text.substr(0, whole))),
                        "is no line of an address trace: over 1000 characters");
    return whole;
}

void AddressTraceReader::parse(std::string_view lines, std::vector<AddressRequest>& block) {
    while (!lines.empty()) {
        const std::size_t length = std::min(lines.find('\n'), lines.size());
        ++line_;
        AddressRequest request;
        if (LineParser(lines.substr(0, length), path_, line_).parse(request)) block.push_back(request);
        lines.remove_prefix(std::min(length + 1, lines.size()));
    }
}

bool AddressTraceReader::next(std::vector<AddressRequest>& block) {
    block.clear();
    while (block.empty() && !ended_) {
        const std::size_t whole = refill();
        parse({buffer_.data(), whole}, block);
        held_ -= whole;
        std::memmove(buffer_.data(), buffer_.data() + whole, held_);
    }
    if (block.empty() && !any_) throw UserError(path_, "holds no request");
    any_ = true;
    return !block.empty();
}

void append_trace_line(std::string& text, const AddressRequest& request) {
    fmt::format_to(std::back_inserter(text), "0x{:x} {} {}\n", request.address,
                   request.write ? "WRITE" : "READ", request.cycle);
}

}  // namespace ropsim
