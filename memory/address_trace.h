// Streams of memory requests, and the text files that DRAM simulators exchange them in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

struct AddressRequest {
    std::uint64_t address = 0;  // bytes
    std::uint64_t cycle = 0;    // not offered before this cycle of the memory controller
    std::uint32_t needs =
        0;  // not offered before the data of the request this many before it are here; 0: none
    bool write = false;
};

class RequestSource {
 public:
    virtual ~RequestSource() = default;
    // Replaces the content of `block` with the next requests; false, and none, at the end.
    virtual bool next(std::vector<AddressRequest>& block) = 0;
};

// Reads lines "0xADDRESS READ|WRITE CYCLE": the address in hexadecimal, the words in either case, the cycle
// in decimal, separated by blanks. Blank lines and lines that start with '#' do not count. Constant memory,
// and a pipe will do.
class AddressTraceReader : public RequestSource {
 public:
    // Throws UserError when the file cannot be read or is compressed.
    explicit AddressTraceReader(std::string path);
    // Throws UserError with file and line on a malformed line, and at the end when there was no request.
    bool next(std::vector<AddressRequest>& block) override;

 private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    std::size_t refill();
    void parse(std::string_view lines, std::vector<AddressRequest>& block);

    std::string path_;
    std::unique_ptr<std::FILE, Close> file_;
    std::vector<char> buffer_;
    std::size_t held_ = 0;  // bytes in the buffer; between calls an unfinished line
    std::uint64_t line_ = 0;
    bool ended_ = false;
    bool any_ = false;
};

// One request as a line of such a file, with its newline.
void append_trace_line(std::string& text, const AddressRequest& request);

}  // namespace ropsim
