// A validation for programs and for readers.
#include "analysis/text_table.h"
#include "analysis/validation.h"
#include "base/version.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json fragment_json(const Fragment& f) {
    return {{"z", f.z},
            {"premultiplied", {f.r, f.g, f.b}},
            {"alpha", f.a},
            {"draw", f.draw},
            {"primitive", primitive_number(f)},
            {"back", faces_back(f)},
            {"coverage", f.coverage}};
}

Json fragment_json(const ListedFragment& f) {
    return {{"z", f.z},
            {"premultiplied", {f.premultiplied[0], f.premultiplied[1], f.premultiplied[2]}},
            {"alpha", f.alpha},
            {"draw", f.coverage_draw >> 16},
            {"primitive", f.primitive & ~kBackFacing},
            {"back", (f.primitive & kBackFacing) != 0},
            {"coverage", f.coverage_draw & 0xFFFFu}};
}

template <class F>
Json fragments_json(const std::vector<F>& fragments) {
    Json list = Json::array();
    for (const F& f : fragments) list.push_back(fragment_json(f));
    return list;
}

Json pixel_json(const DifferingPixel& p) {
    return {{"x", p.x},
            {"y", p.y},
            {"model", p.model},
            {"drawn", p.drawn},
            {"same_fragments", same_fragments(p)},
            {"model_fragments", fragments_json(p.model_fragments)},
            {"drawn_fragments", fragments_json(p.drawn_fragments)}};
}

Json technique_json(const ValidatedTechnique& t) {
    if (!t.failure.empty()) return {{"technique", t.technique}, {"holds", nullptr}, {"why_null", t.failure}};
    const Agreement& a = t.agreement;
    Json json = {{"technique", t.technique},
                 {"rendering", t.rendering},
                 {"holds", !t.differs()},
                 {"stored", format_info(a.stored).name},
                 {"unit", unit_name(a.stored)},
                 {"pixels", a.pixels},
                 {"equal_pixels", a.equal},
                 {"within_pixels", a.within},
                 {"equal_share", a.equal_share()},
                 {"within_share", a.within_share()},
                 {"worst_units", number(a.worst_units)},
                 {"worst_absolute", number(a.worst_absolute)},
                 {"bound",
                  {{"units", a.bound.unit_limit},
                   {"absolute", a.bound.absolute},
                   {"within_share", a.bound.within_share},
                   {"equal_share", a.bound.equal_share}}},
                 {"cause", t.cause()},
                 {"picture", t.picture},
                 {"host", {{"model_seconds", t.model_seconds}, {"drawing_seconds", t.drawing_seconds}}}};
    json["exceptions"] = {{"pixels", a.pixels - a.within},
                          {"other_fragments", a.outside_excused},
                          {"unequal_of_other_fragments", a.unequal_excused},
                          {"places", Json::array()}};
    for (const PixelDifference& p : a.exceptions)
        json["exceptions"]["places"].push_back(
            {{"x", p.x}, {"y", p.y}, {"units", number(p.units)}, {"other_fragments", p.other_fragments}});
    json["first"] = t.first ? pixel_json(*t.first) : Json(nullptr);
    return json;
}

std::string percent(double share) {
    // Rounded down: 100 % means all.
    return fmt::format("{:.4f}", std::floor(1e6 * share) / 1e4);
}

std::string units_text(const Agreement& a) {
    return a.stored == Format::kFloat32 ? fmt::format("{:.2g}", a.worst_units)
                                        : fmt::format("{:.0f}", a.worst_units);
}

}  // namespace

std::string validation_json(const Validation& v) {
    Json json;
    json["ropsim"] = kVersion;
    json["holds"] = v.holds();
    json["trace"] = {{"input", v.options.input}, {"hash", v.trace_hash}, {"scene", v.scene},
                     {"width", v.width},         {"height", v.height},   {"samples", v.samples},
                     {"fragments", v.fragments}};
    json["covered_pixels"] = v.covered;
    json["pixels_of_other_fragments"] = v.other_fragments;
    json["seed"] = v.options.seed;
    json["drawn"] = v.drawn;
    json["driver"] = {{"renderer", v.renderer},
                      {"version", v.driver.version},
                      {"rounds_float16", v.driver.rounds_float16},
                      {"exact_unorm8", v.driver.exact_unorm8},
                      {"exact_snorm8", v.driver.exact_snorm8},
                      {"framebuffer_fetch", v.driver.framebuffer_fetch}};
    json["units"] = {{"ulp", "units in the last place of binary16"},
                     {"codes", "of 255"},
                     {"relative", "of the larger of the two values, at least 1e-6"}};
    json["techniques"] = Json::array();
    for (const ValidatedTechnique& t : v.techniques) json["techniques"].push_back(technique_json(t));
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string validation_table(const Validation& v) {
    std::vector<std::vector<std::string>> rows{
        {"technique", "stored", "worst", "unit", "% equal", "% within", "verdict", "rendering", "cause"}};
    for (const ValidatedTechnique& t : v.techniques) {
        if (!t.failure.empty()) {
            rows.push_back({fmt::format("{}  refused: {}", t.technique, t.failure)});
            continue;
        }
        const Agreement& a = t.agreement;
        rows.push_back({t.technique, std::string(format_info(a.stored).name), units_text(a),
                        unit_name(a.stored), percent(a.equal_share()), percent(a.within_share()),
                        t.differs() ? "DIFFERS" : "agrees", t.rendering,
                        t.cause().empty() ? "-" : t.cause()});
    }
    std::string text = aligned_table(rows);
    for (const Format stored : {Format::kFloat32, Format::kFloat16, Format::kUnorm8})
        for (const ValidatedTechnique& t : v.techniques)
            if (t.failure.empty() && t.agreement.stored == stored) {
                text += fmt::format("bound of {}: {}\n", format_info(stored).name,
                                    agreement_bound(stored, 0).text());
                break;
            }
    text += fmt::format(
        "compared: pixels of 8x8 tiles that something is drawn to; of {} covered pixels {} have other "
        "fragments (not the same bits) in the trace\nthan OpenGL draws, and may be exceptions, 0.1 % of "
        "all at most\n",
        v.covered, v.other_fragments);
    return text;
}

}  // namespace ropsim
