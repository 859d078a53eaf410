// Parses CSV fragments line by line.
#include "traces/csv_reader.h"

#include "base/error.h"
#include "traces/trace_layout.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>

namespace ropsim {

namespace {

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// Cuts the part before the next separator off `rest`.
std::string_view take_part(std::string_view& rest, char separator) {
    const auto at = rest.find(separator);
    const std::string_view part = rest.substr(0, at);
    rest = at == std::string_view::npos ? std::string_view{} : rest.substr(at + 1);
    return trimmed(part);
}

template <typename T>
std::from_chars_result parse(std::string_view text, T& value) {
    return std::from_chars(text.data(), text.data() + text.size(), value);
}

constexpr float kHuge = std::numeric_limits<float>::max();

}  // namespace

CsvReader::CsvReader(const std::string& path) : path_(path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        throw UserError(path, "no such file; give a CSV file");
    in_.open(path, std::ios::binary);
    if (!in_) throw UserError(path, "cannot open; check its permissions");
    while (next_line()) {
        if (line_[0] != '#') {
            parse_header();
            return;
        }
        parse_comment();
    }
    fail("ends before its header; the first line that is no comment must be x,y,z,r,g,b,a");
}

void CsvReader::fail(const std::string& what) const {
    throw UserError(fmt::format("{}:{}", path_, line_number_), what);
}

// Skips empty lines; `line_` is trimmed and not empty afterwards.
bool CsvReader::next_line() {
    while (std::getline(in_, line_)) {
        ++line_number_;
        const std::string_view text = trimmed(line_);
        if (text.empty()) continue;
        if (text.size() != line_.size()) line_ = std::string(text);
        return true;
    }
    if (in_.bad()) fail("cannot be read further");
    return false;
}

std::uint32_t CsvReader::integer(std::string_view text, const std::string& what, std::uint32_t high) const {
    std::uint32_t value = 0;
    const auto [end, error] = parse(text, value);
    if (error != std::errc{} || end != text.data() + text.size() || value > high)
        fail(fmt::format("{} is '{}': must be an integer from 0 to {}", what, text, high));
    return value;
}

float CsvReader::real(std::string_view text, const std::string& what, float low, float high) const {
    float value = 0;
    auto [end, error] = parse(text, value);
    if (error == std::errc::result_out_of_range) {
        // Too small for a float is no fault; too large is.
        double wide = 0;
        error = parse(text, wide).ec;
        if (error == std::errc::result_out_of_range && text.find("e-") != std::string_view::npos) error = {};
        if (std::abs(wide) > static_cast<double>(kHuge)) error = std::errc::result_out_of_range;
        value = error == std::errc{} ? static_cast<float>(wide) : 0.0f;
    }
    if (error != std::errc{} || end != text.data() + text.size() || !(value >= low && value <= high)) {
        if (high == kHuge) fail(fmt::format("{} is '{}': must be a finite number", what, text));
        fail(fmt::format("{} is '{}': must be a number from {} to {}", what, text, low, high));
    }
    return value;
}

void CsvReader::parse_size(std::string_view text) {
    int width = 0;
    int height = 0;
    const auto [middle, error] = parse(text, width);
    const char* const end = text.data() + text.size();
    bool good = error == std::errc{} && middle != end && *middle == 'x';
    if (good) {
        const auto [last, second_error] = std::from_chars(middle + 1, end, height);
        good = second_error == std::errc{} && last == end;
    }
    if (!good || width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide)
        fail(fmt::format("'# size {}': write # size WIDTHxHEIGHT, each from 1 to {}", text, kMaxImageSide));
    preamble_.width = width;
    preamble_.height = height;
}

void CsvReader::parse_comment() {
    std::string_view rest = trimmed(std::string_view(line_).substr(1));
    const std::string_view key = take_part(rest, ' ');
    std::vector<std::string_view> values;
    while (!rest.empty())
        if (const std::string_view part = take_part(rest, ' '); !part.empty()) values.push_back(part);
    const auto need = [&](std::size_t count, const char* form) {
        if (values.size() != count) fail(fmt::format("'{}': write # {}", line_, form));
    };
    if (key == "size") {
        need(1, "size WIDTHxHEIGHT");
        parse_size(values[0]);
    } else if (key == "samples") {
        need(1, "samples N");
        const std::uint32_t samples = integer(values[0], "samples", 16);
        if (samples == 0 || (samples & (samples - 1)) != 0) fail("samples must be 1, 2, 4, 8 or 16");
        preamble_.samples = static_cast<int>(samples);
    } else if (key == "background") {
        need(3, "background R G B");
        for (int c = 0; c < 3; ++c)
            preamble_.background[c] = real(values[static_cast<std::size_t>(c)], "background", -kHuge, kHuge);
    } else if (key == "camera") {
        need(3, "camera NEAR FAR FOVY_DEGREES");
        const float near_plane = real(values[0], "the near plane", 0, kHuge);
        const float far_plane = real(values[1], "the far plane", 0, kHuge);
        const float fovy = real(values[2], "the field of view", 0, 180);
        if (!(near_plane > 0 && near_plane < far_plane && fovy > 0 && fovy < 180))
            fail("the camera needs 0 < NEAR < FAR and 0 < FOVY_DEGREES < 180");
        preamble_.camera = {near_plane, far_plane, fovy};
    }  // any other comment is for people
}

void CsvReader::parse_header() {
    static const std::vector<Column> known{{Field::kX, "x"},
                                           {Field::kY, "y"},
                                           {Field::kZ, "z"},
                                           {Field::kRed, "r"},
                                           {Field::kGreen, "g"},
                                           {Field::kBlue, "b"},
                                           {Field::kAlpha, "a"},
                                           {Field::kRed, "R"},
                                           {Field::kGreen, "G"},
                                           {Field::kBlue, "B"},
                                           {Field::kDraw, "draw"},
                                           {Field::kCoverage, "coverage"},
                                           {Field::kPrimitive, "primitive"}};
    static const std::array<std::string_view, 8> material{"tr",  "tg", "tb", "collimation",
                                                          "eta", "nx", "ny", "nz"};
    std::string_view rest = line_;
    while (!rest.empty()) {
        const std::string_view name = take_part(rest, ',');
        if (std::find(material.begin(), material.end(), name) != material.end())
            fail(fmt::format("column '{}': this version stores no materials; remove the columns tr to nz",
                             name));
        const auto found =
            std::find_if(known.begin(), known.end(), [&](const Column& c) { return c.name == name; });
        if (found == known.end())
            fail(fmt::format(
                "column '{}' is unknown; the header is x,y,z,r,g,b,a (or R,G,B premultiplied), then any "
                "of coverage,draw,primitive",
                name));
        for (const Column& column : columns_)
            if (column.field == found->field) fail(fmt::format("column '{}' is there twice; keep one", name));
        columns_.push_back(*found);
    }
    int capitals = 0;
    for (const char* name : {"x", "y", "z", "r", "g", "b", "a"}) {
        const auto same = [&](const Column& c) {
            return c.name.size() == 1 && (c.name[0] | 0x20) == name[0];
        };
        const auto found = std::find_if(columns_.begin(), columns_.end(), same);
        if (found == columns_.end())
            fail(fmt::format("column '{}' is missing; the header is x,y,z,r,g,b,a", name));
        capitals += found->name != name;
    }
    if (capitals != 0 && capitals != 3)
        fail("mixes r,g,b (straight) with R,G,B (premultiplied); use one kind");
    premultiplied_ = capitals == 3;
}

void CsvReader::parse_field(const Column& column, std::string_view text, Fragment& f) const {
    const auto what = [&] { return fmt::format("column '{}'", column.name); };
    const auto pixel = [&](const std::optional<int>& side) {
        return static_cast<std::uint16_t>(
            integer(text, what(), static_cast<std::uint32_t>(side.value_or(kMaxImageSide) - 1)));
    };
    switch (column.field) {
        case Field::kX:
            f.x = pixel(preamble_.width);
            break;
        case Field::kY:
            f.y = pixel(preamble_.height);
            break;
        case Field::kZ:
            f.z = real(text, what(), 0, 1);
            break;
        case Field::kRed:
            f.r = real(text, what(), -kHuge, kHuge);
            break;
        case Field::kGreen:
            f.g = real(text, what(), -kHuge, kHuge);
            break;
        case Field::kBlue:
            f.b = real(text, what(), -kHuge, kHuge);
            break;
        case Field::kAlpha:
            f.a = real(text, what(), 0, 1);
            break;
        case Field::kCoverage:
            f.coverage = static_cast<std::uint16_t>(integer(text, what(), (1u << preamble_.samples) - 1));
            break;
        case Field::kDraw:
            f.draw = static_cast<std::uint16_t>(integer(text, what(), 65535));
            break;
        case Field::kPrimitive:
            if (!text.empty()) f.primitive = integer(text, what(), std::numeric_limits<std::uint32_t>::max());
            break;
    }
}

bool CsvReader::next(Fragment& fragment) {
    do {
        if (!next_line()) return false;
    } while (line_[0] == '#');
    fragment = Fragment{};
    fragment.coverage = static_cast<std::uint16_t>((1u << preamble_.samples) - 1);
    fragment.primitive = static_cast<std::uint32_t>(line_number_);
    const auto fields = static_cast<std::size_t>(std::count(line_.begin(), line_.end(), ',')) + 1;
    if (fields != columns_.size())
        fail(fmt::format("has {} fields where the header names {} columns", fields, columns_.size()));
    std::string_view rest = line_;
    for (const Column& column : columns_) parse_field(column, take_part(rest, ','), fragment);
    if (!premultiplied_) {
        fragment.r *= fragment.a;
        fragment.g *= fragment.a;
        fragment.b *= fragment.a;
    }
    return true;
}

}  // namespace ropsim
