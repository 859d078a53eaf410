// Parses CSV fragments line by line.
#include "traces/interchange/csv_reader.h"

#include "base/error.h"
#include "traces/interchange/csv_values.h"
#include "traces/trace_layout.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>

namespace ropsim {

namespace {

// Cuts the part before the next separator off `rest`.
std::string_view take_part(std::string_view& rest, char separator) {
    const auto at = rest.find(separator);
    const std::string_view part = rest.substr(0, at);
    rest = at == std::string_view::npos ? std::string_view{} : rest.substr(at + 1);
    return trimmed(part);
}

constexpr float kHuge = std::numeric_limits<float>::max();

}  // namespace

// The comments before the header.
struct CsvReader::PreambleParser {
    const CsvReader& reader;
    CsvPreamble& preamble;
    std::string_view key;
    std::vector<std::string_view> values;

    PreambleParser(CsvReader& csv, std::string_view line) : reader(csv), preamble(csv.preamble_) {
        std::string_view rest = trimmed(line.substr(1));
        key = take_part(rest, ' ');
        while (!rest.empty())
            if (const std::string_view part = take_part(rest, ' '); !part.empty()) values.push_back(part);
    }

    void need(std::size_t count, const char* form) const {
        if (values.size() != count) reader.fail(fmt::format("'{}': write # {}", reader.line_, form));
    }
    float real(std::size_t i, const char* what, float low, float high) const {
        const std::optional<float> value = csv_real(values[i]);
        if (value && *value >= low && *value <= high) return *value;
        if (high == kHuge) reader.fail(fmt::format("{} is '{}': must be a finite number", what, values[i]));
        reader.fail(fmt::format("{} is '{}': must be a number from {} to {}", what, values[i], low, high));
    }
    std::uint64_t integer(std::size_t i, const char* what, std::uint64_t high) const {
        const std::optional<std::uint64_t> value = csv_integer(values[i]);
        if (!value || *value > high)
            reader.fail(fmt::format("{} is '{}': must be an integer from 0 to {}", what, values[i], high));
        return *value;
    }

    void size() const {
        need(1, "size WIDTHxHEIGHT");
        const auto cross = values[0].find('x');
        const std::uint64_t width = csv_integer(values[0].substr(0, cross)).value_or(0);
        const std::uint64_t height =
            cross == std::string_view::npos ? 0 : csv_integer(values[0].substr(cross + 1)).value_or(0);
        constexpr std::uint64_t kMax = kMaxImageSide;
        if (width < 1 || height < 1 || width > kMax || height > kMax)
            reader.fail(
                fmt::format("'# size {}': write # size WIDTHxHEIGHT, each from 1 to {}", values[0], kMax));
        preamble.width = static_cast<int>(width);
        preamble.height = static_cast<int>(height);
    }
    void camera() const {
        need(3, "camera NEAR FAR FOVY_DEGREES");
        const float near_plane = real(0, "the near plane", 0, kHuge);
        const float far_plane = real(1, "the far plane", 0, kHuge);
        const float fovy = real(2, "the field of view", 0, 180);
        if (!(near_plane > 0 && near_plane < far_plane && fovy > 0 && fovy < 180))
            reader.fail("the camera needs 0 < NEAR < FAR and 0 < FOVY_DEGREES < 180");
        preamble.camera = {near_plane, far_plane, fovy};
    }
    void parse() const {
        if (key == "size") {
            size();
        } else if (key == "samples") {
            need(1, "samples N");
            const std::uint64_t samples = integer(0, "samples", 16);
            if (samples == 0 || (samples & (samples - 1)) != 0)
                reader.fail("samples must be 1, 2, 4, 8 or 16");
            preamble.samples = static_cast<int>(samples);
        } else if (key == "background") {
            need(3, "background R G B");
            for (int c = 0; c < 3; ++c)
                preamble.background[c] = real(static_cast<std::size_t>(c), "background", -kHuge, kHuge);
        } else if (key == "camera") {
            camera();
        } else if (key == "color_storage") {
            need(1, "color_storage float16|float32");
            if (values[0] != "float16" && values[0] != "float32")
                reader.fail(fmt::format("color_storage is '{}': must be float16 or float32", values[0]));
            preamble.color_storage = values[0] == "float16" ? ColorStorage::kFloat16 : ColorStorage::kFloat32;
        } else if (key == "non_finite") {
            need(1, "non_finite 0|1");
            preamble.non_finite = integer(0, "non_finite", 1) == 1;
        } else if (key == "draws" && values.size() == 1) {
            preamble.draws = static_cast<int>(integer(0, "draws", 65536));
        } else if (key == "fragments" && values.size() == 1) {
            preamble.fragments = integer(0, "fragments", std::numeric_limits<std::uint64_t>::max());
        }  // any other comment is for people
    }
};

CsvReader::CsvReader(const std::string& path) : lines_(path) {
    while (next_line()) {
        if (line_[0] != '#') {
            parse_header();
            return;
        }
        PreambleParser(*this, line_).parse();
    }
    fail("ends before its header; the first line that is no comment must be x,y,z,r,g,b,a");
}

void CsvReader::fail(const std::string& what) const {
    throw UserError(lines_.place(), what);
}

// Skips empty lines.
bool CsvReader::next_line() {
    while (lines_.next(line_))
        if (!line_.empty()) return true;
    return false;
}

const std::vector<CsvReader::Column>& CsvReader::known_columns() {
    constexpr std::size_t kFragment = offsetof(CsvRow, fragment);
    constexpr std::size_t kSlope = offsetof(CsvRow, slope);
    constexpr std::size_t kMaterial = offsetof(CsvRow, material);
    constexpr std::size_t kNormal = kMaterial + offsetof(Material, normal);
    static const std::vector<Column> known{
        {"x", Kind::kX, 0},
        {"y", Kind::kY, 0},
        {"z", Kind::kShare, kFragment + offsetof(Fragment, z)},
        {"r", Kind::kReal, kFragment + offsetof(Fragment, r)},
        {"g", Kind::kReal, kFragment + offsetof(Fragment, g)},
        {"b", Kind::kReal, kFragment + offsetof(Fragment, b)},
        {"R", Kind::kReal, kFragment + offsetof(Fragment, r)},
        {"G", Kind::kReal, kFragment + offsetof(Fragment, g)},
        {"B", Kind::kReal, kFragment + offsetof(Fragment, b)},
        {"a", Kind::kShare, kFragment + offsetof(Fragment, a)},
        {"draw", Kind::kDraw, 0},
        {"coverage", Kind::kCoverage, 0},
        {"primitive", Kind::kPrimitive, 0},
        {"facing", Kind::kFacing, 0},
        {"dzdx", Kind::kReal, kSlope + offsetof(DepthSlope, dx)},
        {"dzdy", Kind::kReal, kSlope + offsetof(DepthSlope, dy)},
        {"tr", Kind::kShare, kMaterial},
        {"tg", Kind::kShare, kMaterial + sizeof(float)},
        {"tb", Kind::kShare, kMaterial + 2 * sizeof(float)},
        {"collimation", Kind::kShare, kMaterial + offsetof(Material, collimation)},
        {"eta", Kind::kReal, kMaterial + offsetof(Material, eta)},
        {"nx", Kind::kReal, kNormal},
        {"ny", Kind::kReal, kNormal + sizeof(float)},
        {"nz", Kind::kReal, kNormal + 2 * sizeof(float)}};
    return known;
}

void CsvReader::parse_header() {
    std::string_view rest = line_;
    while (!rest.empty()) {
        const std::string_view name = take_part(rest, ',');
        const auto found = std::find_if(known_columns().begin(), known_columns().end(),
                                        [&](const Column& c) { return c.name == name; });
        if (found == known_columns().end())
            fail(fmt::format(
                "column '{}' is unknown; the header is x,y,z,r,g,b,a (or R,G,B premultiplied), then any "
                "of coverage,draw,primitive,facing,dzdx,dzdy,tr,tg,tb,collimation,eta,nx,ny,nz",
                name));
        for (const Column& column : columns_)
            if (column.kind == found->kind && column.offset == found->offset)
                fail(fmt::format("column '{}' is there twice; keep one", name));
        has_slopes_ = has_slopes_ || (found->offset >= offsetof(CsvRow, slope) &&
                                      found->offset < offsetof(CsvRow, slope) + sizeof(DepthSlope));
        has_materials_ = has_materials_ || found->offset >= offsetof(CsvRow, material);
        columns_.push_back(*found);
    }
    check_columns();
}

void CsvReader::check_columns() {
    const auto has = [&](std::string_view name) {
        return std::any_of(columns_.begin(), columns_.end(), [&](const Column& c) { return c.name == name; });
    };
    int capitals = 0;
    for (const char* name : {"x", "y", "z", "r", "g", "b", "a"}) {
        const std::string capital(1, static_cast<char>(name[0] & ~0x20));
        const bool has_capital = std::strchr("rgb", name[0]) != nullptr && has(capital);
        if (!has(name) && !has_capital)
            fail(fmt::format("column '{}' is missing; the header is x,y,z,r,g,b,a", name));
        capitals += has_capital ? 1 : 0;
    }
    if (capitals != 0 && capitals != 3)
        fail("mixes r,g,b (straight) with R,G,B (premultiplied); use one kind");
    premultiplied_ = capitals == 3;
}

void CsvReader::parse_field(const Column& column, std::string_view text, CsvRow& row) const {
    const auto integer = [&](std::uint64_t high) {
        const std::optional<std::uint64_t> value = csv_integer(text);
        if (!value || *value > high)
            fail(
                fmt::format("column '{}' is '{}': must be an integer from 0 to {}", column.name, text, high));
        return *value;
    };
    const auto pixel = [&](const std::optional<int>& side) {
        return static_cast<std::uint16_t>(
            integer(static_cast<std::uint64_t>(side.value_or(kMaxImageSide) - 1)));
    };
    switch (column.kind) {
        case Kind::kX:
            row.fragment.x = pixel(preamble_.width);
            return;
        case Kind::kY:
            row.fragment.y = pixel(preamble_.height);
            return;
        case Kind::kCoverage:
            row.fragment.coverage = static_cast<std::uint16_t>(integer((1u << preamble_.samples) - 1));
            return;
        case Kind::kDraw:
            row.fragment.draw = static_cast<std::uint16_t>(
                integer(static_cast<std::uint64_t>(std::max(1, preamble_.draws.value_or(65536)) - 1)));
            return;
        case Kind::kPrimitive:
            if (!text.empty())
                row.fragment.primitive = (row.fragment.primitive & kBackFacing) |
                                         static_cast<std::uint32_t>(integer(kBackFacing - 1));
            return;
        case Kind::kFacing:
            row.fragment.primitive |= integer(1) == 1 ? kBackFacing : 0;
            return;
        case Kind::kShare:
        case Kind::kReal:
            break;
    }
    const std::optional<float> value = csv_real(text);
    const float low = column.kind == Kind::kShare ? 0.0f : -kHuge;
    const float high = column.kind == Kind::kShare ? 1.0f : kHuge;
    if (!value || !(preamble_.non_finite || (*value >= low && *value <= high))) {
        if (column.kind == Kind::kShare)
            fail(fmt::format("column '{}' is '{}': must be a number from 0 to 1", column.name, text));
        fail(fmt::format("column '{}' is '{}': must be a finite number", column.name, text));
    }
    std::memcpy(reinterpret_cast<char*>(&row) + column.offset, &*value, sizeof(float));
}

bool CsvReader::next(CsvRow& row) {
    do {
        if (!next_line()) return false;
    } while (line_[0] == '#');
    row = CsvRow{};
    row.fragment.coverage = static_cast<std::uint16_t>((1u << preamble_.samples) - 1);
    row.fragment.primitive = static_cast<std::uint32_t>(lines_.number()) & ~kBackFacing;
    const auto fields = static_cast<std::size_t>(std::count(line_.begin(), line_.end(), ',')) + 1;
    if (fields != columns_.size())
        fail(fmt::format("has {} fields where the header names {} columns", fields, columns_.size()));
    if (preamble_.draws == 0) fail("a fragment where '# draws 0' says that nothing is drawn");
    std::string_view rest = line_;
    for (const Column& column : columns_) parse_field(column, take_part(rest, ','), row);
    if (!premultiplied_) {
        row.fragment.r *= row.fragment.a;
        row.fragment.g *= row.fragment.a;
        row.fragment.b *= row.fragment.a;
    }
    return true;
}

}  // namespace ropsim
