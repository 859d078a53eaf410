// Verdicts, pictures and the first differing pixels of a validation.
#include "analysis/report/report_validation.h"

#include "analysis/comparison_table.h"
#include "analysis/html.h"
#include "analysis/report/picture_encoding.h"
#include "analysis/report/report_pictures.h"
#include "analysis/report/report_widgets.h"
#include "base/error.h"
#include "base/parallel.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr float kWhiteUnits = 16;  // as in the difference pictures

ReportTable verdicts(const Validation& validation) {
    ReportTable table{"verdicts",
                      "Compared are pixels of 8x8 tiles that something is drawn to.",
                      {{"technique"},
                       {"verdict", CellKind::kChoice},
                       {"stored", CellKind::kChoice},
                       {"worst", CellKind::kNumber, "units", "the largest difference of a channel"},
                       {"unit", CellKind::kChoice},
                       {"equal", CellKind::kNumber, "% of pixels", "the same bits in all channels"},
                       {"within", CellKind::kNumber, "% of pixels", "within the bound of the format"},
                       {"pixels", CellKind::kNumber},
                       {"rendering"},
                       {"cause", CellKind::kText, "", "why values differ"}},
                      {}};
    for (const ValidatedTechnique& t : validation.techniques) {
        if (!t.failure.empty()) {
            std::vector<ReportCell> row(table.columns.size(), ReportCell{report_absent(), {}, "none"});
            row[0] = {t.technique};
            row[1] = {"refused"};
            row.back() = {t.failure};
            table.rows.push_back(std::move(row));
            continue;
        }
        const Agreement& a = t.agreement;
        const auto percent = [](double share) {  // rounded down: 100 means all
            return ReportCell{fmt::format("{:.4f}", std::floor(1e6 * share) / 1e4), share};
        };
        table.rows.push_back({{t.technique},
                              {t.differs() ? "differs" : "agrees", {}, t.differs() ? "bad" : "good"},
                              {std::string(format_info(a.stored).name)},
                              {fmt::format("{:.2g}", a.worst_units), a.worst_units},
                              {std::string(unit_name(a.stored))},
                              percent(a.equal_share()),
                              percent(a.within_share()),
                              {format_measured(static_cast<double>(a.pixels), 0, "\u202f", report_absent()),
                               static_cast<double>(a.pixels)},
                              {t.rendering},
                              {t.cause()}});
    }
    return table;
}

// Three channels as an image of their own.
Image channels_of(const Image& image, const std::string& prefix, float scale) {
    Image out(image.width, image.height, {"R", "G", "B"});
    int c = 0;
    for (const char* name : {"R", "G", "B"}) {
        const int from = image.channel(prefix + name);
        if (from < 0) throw UserError(prefix + name, "is missing");
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) out.pixel(x, y)[c] = image.pixel(x, y)[from] * scale;
        ++c;
    }
    return out;
}

// Pictures that are the same, as most of the model's and OpenGL's are, are kept once.
class PictureStore {
 public:
    std::string add(Picture picture) {
        const auto [found, fresh] = ids_.try_emplace(picture.rgb, pictures_.size());
        if (fresh) pictures_.push_back(std::move(picture));
        return id(found->second);
    }
    // How exactly the worst of them is kept.
    PictureLoss finish(std::size_t bytes, std::vector<ReportData>& data) const {
        const auto encoded = encode_within(pictures_, bytes, default_threads());
        PictureLoss loss = PictureLoss::kNone;
        for (std::size_t i = 0; i < encoded.size(); ++i) {
            data.push_back({id(i), encoded[i].uri, "text/plain"});
            loss = std::max(loss, encoded[i].loss);
        }
        return loss;
    }

 private:
    static std::string id(std::size_t index) { return fmt::format("picture-{}", index); }
    std::map<std::vector<std::uint8_t>, std::size_t> ids_;
    std::vector<Picture> pictures_;
};

ReportWidget pictures(const Validation& validation, std::size_t bytes) {
    Json json{{"width", validation.width}, {"height", validation.height}, {"detail", {0, 0, 0, 0}},
              {"reference", nullptr},      {"layers", nullptr},           {"pixels", nullptr}};
    json["names"] = {{"ours", "model"},
                     {"theirs", "OpenGL"},
                     {"difference", "units apart"},
                     {"note", "black: the same bits, or not compared · white: 16 units apart or more"}};
    json["techniques"] = Json::array();
    PictureStore store;
    std::string unreadable;
    for (const ValidatedTechnique& t : validation.techniques) {
        if (!t.failure.empty()) continue;
        const std::filesystem::path picture(t.picture);
        const std::string file =
            (std::filesystem::path(validation.options.directory) / picture.stem()).string() + ".exr";
        try {
            const Image image = read_exr(file);
            const Region whole{0, 0, image.width, image.height};
            const auto shown = [&](const std::string& prefix, float scale) {
                return store.add(image_picture(channels_of(image, prefix, scale), whole, 1));
            };
            json["techniques"].push_back({{"name", t.technique},
                                          {"image", shown("model.", 1)},
                                          {"reference", shown("", 1)},
                                          {"difference", shown("units.", 1 / kWhiteUnits)},
                                          {"tiles", nullptr},
                                          {"rmse", t.agreement.worst_absolute}});
        } catch (const UserError& error) {
            unreadable +=
                fmt::format("<p class=\"note\">{}: {}</p>\n", html_escape(file), html_escape(error.what()));
        }
    }
    if (json["techniques"].empty()) return {unreadable, {}};
    ReportWidget widget;
    const PictureLoss loss = store.finish(bytes, widget.data);
    widget.html = fmt::format(
        "<h3>Pictures</h3>\n<p class=\"note\">Pictures are {}.</p>\n"
        "<div class=\"views\" data-widget=\"views\" data-source=\"views\"></div>\n{}",
        loss_text(loss), unreadable);
    widget.data.push_back({"views", json.dump(-1, ' ', false, Json::error_handler_t::replace)});
    return widget;
}

std::string facts(const Validation& v) {
    std::string out = "<div class=\"facts\">";
    const auto fact = [&](const std::string& text) { out += "<span>" + html_escape(text) + "</span>"; };
    if (!v.scene.empty()) fact(v.scene);
    fact(fmt::format("{} × {} pixels, {} {} each", v.width, v.height, v.samples,
                     v.samples == 1 ? "sample" : "samples"));
    const auto count = [](std::uint64_t n) {
        return format_measured(static_cast<double>(n), 0, "\u202f", report_absent());
    };
    fact(count(v.fragments) + " fragments");
    fact(fmt::format("drawn as {} by {}", v.drawn, v.renderer));
    fact(fmt::format("of {} covered pixels {} have other fragments than OpenGL draws", count(v.covered),
                     count(v.other_fragments)));
    fact("hash " + v.trace_hash);
    return out + "</div>\n";
}

std::string first_pixels(const Validation& validation) {
    std::string rows;
    for (const ValidatedTechnique& t : validation.techniques) {
        if (!t.first) continue;
        const auto color = [](const std::array<float, 3>& rgb) {
            return fmt::format("{:.6g} {:.6g} {:.6g}", rgb[0], rgb[1], rgb[2]);
        };
        rows += fmt::format(
            "<tr><th scope=\"row\">{}</th><td>{}, {}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            html_escape(t.technique), t.first->x, t.first->y, color(t.first->model), color(t.first->drawn),
            same_fragments(*t.first) ? "the same" : "others");
    }
    if (rows.empty()) return {};
    return "<h3>The first pixel that is not the same</h3>\n<div class=\"scroll\"><table><thead><tr><th "
           "scope=\"col\">technique</th><th scope=\"col\">pixel</th><th scope=\"col\">model</th><th "
           "scope=\"col\">OpenGL</th><th scope=\"col\">fragments</th></tr></thead>\n<tbody>\n" +
           rows + "</tbody></table></div>\n";
}

}  // namespace

std::string validation_report(const Validation& validation, const std::string& command,
                              std::size_t picture_bytes) {
    ReportPage page("The model against OpenGL",
                    "the same frame, the same techniques, in GLSL that shares nothing with the model.");
    ReportSection section{"validation",
                          validation.holds() ? "All techniques agree" : "Some techniques differ"};
    section += facts(validation);
    section += report_table(verdicts(validation));
    section += pictures(validation, picture_bytes);
    section += first_pixels(validation);
    section += report_command(command);
    page.add(std::move(section));
    return page.html();
}

}  // namespace ropsim
