// Parses CSV fragments line by line.
#pragma once

#include "traces/trace.h"

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

// What the comment lines before the header say.
struct CsvPreamble {
    std::optional<int> width, height;
    int samples = 1;
    glm::vec3 background{0.0f};
    struct Lens {
        float near_plane, far_plane, fovy_degrees;
    };
    std::optional<Lens> camera;
};

// Opening reads the preamble and the header. Every fault is a UserError that names file and line.
class CsvReader {
 public:
    explicit CsvReader(const std::string& path);
    const CsvPreamble& preamble() const { return preamble_; }
    // The next fragment, colour premultiplied; false at the end.
    bool next(Fragment& fragment);

 private:
    enum class Field { kX, kY, kZ, kRed, kGreen, kBlue, kAlpha, kCoverage, kDraw, kPrimitive };
    struct Column {
        Field field;
        std::string name;
    };

    bool next_line();
    void parse_comment();
    void parse_size(std::string_view text);
    void parse_header();
    void parse_field(const Column& column, std::string_view text, Fragment& fragment) const;
    std::uint32_t integer(std::string_view text, const std::string& what, std::uint32_t high) const;
    float real(std::string_view text, const std::string& what, float low, float high) const;
    [[noreturn]] void fail(const std::string& what) const;

    std::string path_;
    std::ifstream in_;
    std::string line_;
    std::uint64_t line_number_ = 0;
    CsvPreamble preamble_;
    std::vector<Column> columns_;
    bool premultiplied_ = false;
};

}  // namespace ropsim
