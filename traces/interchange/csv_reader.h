// Parses CSV fragments line by line.
#pragma once

#include "traces/interchange/line_reader.h"
#include "traces/trace.h"

#include <cstdint>
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
    ColorStorage color_storage = ColorStorage::kFloat32;
    bool non_finite = false;  // any value may stand in any real column
    std::optional<int> draws;
    std::optional<std::uint64_t> fragments;  // how many there should be
};

struct CsvRow {
    Fragment fragment;
    DepthSlope slope;
    Material material;
};

// Opening reads the preamble and the header. Every fault is a UserError that names file and line.
class CsvReader {
 public:
    explicit CsvReader(const std::string& path);
    const CsvPreamble& preamble() const { return preamble_; }
    bool has_slopes() const { return has_slopes_; }
    bool has_materials() const { return has_materials_; }
    // The next fragment, colour premultiplied; false at the end.
    bool next(CsvRow& row);

 private:
    enum class Kind : std::uint8_t { kX, kY, kCoverage, kDraw, kPrimitive, kFacing, kShare, kReal };
    struct Column {
        const char* name;
        Kind kind;
        std::size_t offset;  // of the float in a CsvRow, for kShare and kReal
    };
    struct PreambleParser;

    static const std::vector<Column>& known_columns();
    bool next_line();
    void parse_header();
    void check_columns();
    void parse_field(const Column& column, std::string_view text, CsvRow& row) const;
    [[noreturn]] void fail(const std::string& what) const;

    LineReader lines_;
    std::string_view line_;
    CsvPreamble preamble_;
    std::vector<Column> columns_;
    bool premultiplied_ = false;
    bool has_slopes_ = false;
    bool has_materials_ = false;
};

}  // namespace ropsim
