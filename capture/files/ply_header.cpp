// Reads PLY headers line by line.
#include "capture/files/ply_header.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace ropsim {
namespace {

struct ScalarType {
    std::string_view name;
    std::size_t bytes;
    PlyScalar scalar;
};
constexpr std::array<ScalarType, 16> kScalarTypes = {{{"float", 4, PlyScalar::kFloat},
                                                      {"float32", 4, PlyScalar::kFloat},
                                                      {"double", 8, PlyScalar::kDouble},
                                                      {"float64", 8, PlyScalar::kDouble},
                                                      {"char", 1, PlyScalar::kOther},
                                                      {"int8", 1, PlyScalar::kOther},
                                                      {"uchar", 1, PlyScalar::kOther},
                                                      {"uint8", 1, PlyScalar::kOther},
                                                      {"short", 2, PlyScalar::kOther},
                                                      {"int16", 2, PlyScalar::kOther},
                                                      {"ushort", 2, PlyScalar::kOther},
                                                      {"uint16", 2, PlyScalar::kOther},
                                                      {"int", 4, PlyScalar::kOther},
                                                      {"int32", 4, PlyScalar::kOther},
                                                      {"uint", 4, PlyScalar::kOther},
                                                      {"uint32", 4, PlyScalar::kOther}}};

std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    std::size_t at = 0;
    while ((at = line.find_first_not_of(" \t\r", at)) != std::string_view::npos) {
        const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
        words.push_back(line.substr(at, end - at));
        at = end;
    }
    return words;
}

// Reads the header line by line.
class HeaderParser {
 public:
    HeaderParser(std::string_view text, const std::string& name) : text_(text), name_(name) {}

    PlyHeader parse() {
        if (next_line() != std::vector<std::string_view>{"ply"}) refuse("is not a PLY file: no 'ply'");
        while (true) {
            const std::vector<std::string_view> words = next_line();
            if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
            if (words[0] == "end_header") break;
            if (words[0] == "format") {
                read_format(words);
            } else if (words[0] == "element") {
                read_element(words);
            } else if (words[0] == "property") {
                read_property(words);
            } else {
                refuse("neither format, element, property, comment nor end_header");
            }
        }
        if (!format_) refuse("the header ends without a format line");
        if (elements_ == 0) refuse("the header ends without an element vertex");
        header_.bytes = at_;
        return std::move(header_);
    }

 private:
    [[noreturn]] void refuse(const std::string& what) const {
        throw UserError(name_, fmt::format("line {} of the header: {}; give a .ply as 3D Gaussian splatting "
                                           "writes it",
                                           line_, what));
    }

    std::vector<std::string_view> next_line() {
        ++line_;
        const std::size_t end = text_.find('\n', at_);
        if (end == std::string_view::npos) refuse("has no end");
        const std::string_view line = text_.substr(at_, end - at_);
        at_ = end + 1;
        return words_of(line);
    }

    void read_format(const std::vector<std::string_view>& words) {
        if (words.size() != 3 || words[1] != "binary_little_endian" || words[2] != "1.0") {
            refuse("the format is not binary_little_endian 1.0");
        }
        format_ = true;
    }

    void read_element(const std::vector<std::string_view>& words) {
        if (++elements_ > 1) {
            header_.more_after = true;
            return;
        }
        if (words.size() != 3 || words[1] != "vertex")
            refuse("the first element is not 'vertex' and a count");
        const char* end = words[2].data() + words[2].size();
        const auto [stop, error] = std::from_chars(words[2].data(), end, header_.count);
        if (error != std::errc() || stop != end) refuse("the count of vertices is no number");
    }

    void read_property(const std::vector<std::string_view>& words) {
        if (elements_ == 0) refuse("a property before any element");
        if (elements_ > 1) return;
        if (words.size() != 3) refuse("a vertex's property is not a type and a name");
        const auto type = std::find_if(kScalarTypes.begin(), kScalarTypes.end(),
                                       [&](const ScalarType& t) { return t.name == words[1]; });
        if (type == kScalarTypes.end()) refuse("no such type of number");
        for (const PlyProperty& other : header_.properties)
            if (other.name == words[2]) refuse("this property has been there before");
        header_.properties.push_back({std::string(words[2]), header_.stride, type->scalar});
        header_.stride += type->bytes;
    }

    std::string_view text_;
    const std::string& name_;
    PlyHeader header_;
    std::size_t at_ = 0;
    int line_ = 0;
    int elements_ = 0;
    bool format_ = false;
};

}  // namespace

PlyHeader parse_ply_header(std::string_view text, const std::string& name) {
    return HeaderParser(text, name).parse();
}

}  // namespace ropsim
