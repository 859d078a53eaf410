// Puts the parts of the page together.
#include "analysis/report.h"

#include "analysis/comparison_table.h"
#include "analysis/html.h"
#include "analysis/report_bars.h"
#include "analysis/report_pictures.h"
#include "analysis/report_resources.h"
#include "analysis/report_tables.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/version.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>

namespace ropsim {
namespace {

std::string failures_only(const std::vector<RunRecord>& runs) {
    std::string out;
    for (const RunRecord& run : runs)
        if (!run.failure.empty())
            out +=
                fmt::format("<p>{}: failed: {}</p>\n", html_escape(run.technique), html_escape(run.failure));
    return out;
}

std::string facts(const ComparisonOfOneTrace& comparison) {
    double covered = 0, layers = 0, most = 0, ties = 0;
    const Image& reference = comparison.reference;
    const int layer_channel = reference.channel("layers"), tie_channel = reference.channel("ties");
    if (layer_channel >= 0) {
        for (int y = 0; y < reference.height; ++y)
            for (int x = 0; x < reference.width; ++x) {
                const double here = reference.pixel(x, y)[layer_channel];
                covered += here > 0 ? 1 : 0;
                layers += here;
                most = std::max(most, here);
                if (tie_channel >= 0) ties += reference.pixel(x, y)[tie_channel];
            }
    }
    std::string out = "<div class=\"facts\">";
    const auto fact = [&](const std::string& text) { out += "<span>" + html_escape(text) + "</span>"; };
    if (!comparison.scene.empty()) fact(comparison.scene);
    fact(fmt::format("{} × {} pixels, {} {} each", comparison.width, comparison.height, comparison.samples,
                     comparison.samples == 1 ? "sample" : "samples"));
    fact(report_number(comparison.fragments, 0) + " fragments");
    if (covered > 0) {
        const double pixels = static_cast<double>(reference.width) * reference.height;
        fact(fmt::format("{:.1f}% of pixels covered, {:.1f} visible layers there on average, {:.0f} at most",
                         100 * covered / pixels, layers / covered, most));
        if (ties > 0) fact(report_number(ties, 0) + " pairs of equal depth");
    }
    fact("hash " + comparison.hash);
    return out + "</div>\n";
}

// A picture stored once in the page and drawn wherever it is used.
std::string stored(const std::string& id, const Picture& picture) {
    return fmt::format(
        "<svg class=\"store\" aria-hidden=\"true\"><defs><image id=\"{}\" width=\"{}\" height=\"{}\" "
        "href=\"{}\"/></defs></svg>\n",
        id, picture.width, picture.height, data_uri(picture));
}

std::string used(const std::string& id, const Region& region, int reduction, const char* style) {
    return fmt::format(
        "<svg class=\"reference{}\" role=\"img\" aria-label=\"reference\" viewBox=\"0 0 {} {}\">"
        "<use href=\"#{}\"/></svg>",
        style, (region.width + reduction - 1) / reduction, (region.height + reduction - 1) / reduction, id);
}

std::string embedded(const Picture& picture, const std::string& text, const char* style) {
    return fmt::format("<img class=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\" src=\"{}\">", style,
                       picture.width, picture.height, html_escape(text), data_uri(picture));
}

struct Views {
    Region whole, detail;
    int reduction;
    std::string id;
};

std::string triple(const Image& image, const Image& reference, const Region& region, int reduction,
                   const std::string& id, const std::string& name, bool pixels) {
    const char* style = pixels ? "pixels" : "";
    return "<div class=\"triple\">" + embedded(image_picture(image, region, reduction), name, style) +
           embedded(difference_picture(image, reference, region, reduction), name + ", difference times 8",
                    style) +
           used(id, region, reduction, pixels ? " pixels" : "") + "</div>\n";
}

std::string pictures_of(const RunRecord& run, const Image& image, const Image& reference,
                        const Views& views) {
    std::string out =
        fmt::format("<div class=\"pictures\"><div class=\"head\"><h4>{}</h4><span class=\"soft\">",
                    html_escape(run.technique));
    out += fmt::format("RMSE {} · PSNR {} dB · FLIP {}</span></div>\n", report_number(run.rmse8, 3),
                       report_number(run.psnr_db, 2), report_number(run.flip, 4));
    out += triple(image, reference, views.whole, views.reduction, views.id, run.technique,
                  views.whole.width < 320);
    if (views.detail.width > 0)
        out +=
            "<div style=\"height:8px\"></div>" +
            triple(image, reference, views.detail, 1, views.id + "-detail", run.technique + ", detail", true);
    return out + "</div>\n";
}

std::string pictures_section(const ComparisonOfOneTrace& comparison, const std::string& id) {
    std::vector<const RunRecord*> runs;
    std::vector<Image> images;
    std::string unreadable;
    for (const RunRecord& run : comparison.runs) {
        if (!run.failure.empty()) continue;
        const std::string file = (std::filesystem::path(run.directory) / "image.exr").string();
        try {
            Image image = read_exr(file);
            if (image.width != comparison.reference.width || image.height != comparison.reference.height ||
                image.channel("R") < 0 || image.channel("G") < 0 || image.channel("B") < 0)
                throw UserError(file, "is not an image of this trace");
            images.push_back(std::move(image));
            runs.push_back(&run);
        } catch (const UserError& error) {
            unreadable += fmt::format("<p class=\"note\">{}: {}</p>\n", html_escape(error.where()),
                                      html_escape(error.what()));
        }
    }
    if (images.empty()) return unreadable;
    std::vector<const Image*> all;
    all.reserve(images.size());
    for (const Image& image : images) all.push_back(&image);
    const Image& reference = comparison.reference;
    const Views views{{0, 0, reference.width, reference.height},
                      detail_region(all, reference),
                      reduction_for(reference.width),
                      id};
    std::string out =
        "<h3>Pictures</h3>\n<p class=\"note\">From left to right: the technique, its difference from the "
        "reference (8 times, linear, around grey: brighter is too bright), the reference.";
    if (views.reduction > 1)
        out += fmt::format(" Reduced {}:1; the difference keeps the largest of each {} pixels.",
                           views.reduction, views.reduction * views.reduction);
    if (views.detail.width > 0)
        out += fmt::format(" Below each, the {} × {} pixels from ({}, {}) where the techniques err most.",
                           views.detail.width, views.detail.height, views.detail.x, views.detail.y);
    out += "</p>\n" + stored(id, image_picture(reference, views.whole, views.reduction));
    if (views.detail.width > 0) out += stored(id + "-detail", image_picture(reference, views.detail, 1));
    for (std::size_t i = 0; i < images.size(); ++i) out += pictures_of(*runs[i], images[i], reference, views);
    return out + unreadable;
}

std::string section(const ComparisonOfOneTrace& comparison, std::size_t index) {
    const std::string id = fmt::format("trace-{}", index + 1);
    std::string out = fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n", id, html_escape(comparison.name));
    out += facts(comparison);
    const std::string table = number_table(comparison.runs, comparison_columns());
    out += table.empty() ? failures_only(comparison.runs) : table;
    out += sample_notes(comparison.runs);
    out +=
        "<p class=\"note\">Errors are of linear values against exact compositing; bytes are per fragment of "
        "the trace. "
        "A dash was not measured.</p>\n";
    const std::string traffic = traffic_bars(comparison.runs), cycles = stage_bars(comparison.runs);
    out += traffic + cycles + pictures_section(comparison, id + "-reference");
    std::vector<RunRecord> successful;
    std::copy_if(comparison.runs.begin(), comparison.runs.end(), std::back_inserter(successful),
                 [](const RunRecord& run) { return run.failure.empty(); });
    const std::string memory = number_table(successful, memory_columns());
    if (!memory.empty()) out += "<h3>Memory system</h3>\n" + memory;
    out += path_table(comparison.runs) + configuration_list(comparison.runs) + command_list(comparison.runs);
    return out + "</section>\n";
}

}  // namespace

std::string report_html(const std::vector<ComparisonOfOneTrace>& comparisons, const std::string& title) {
    const std::string heading = title.empty() ? "Transparency techniques compared" : title;
    std::string out =
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
        "content=\"width=device-width, initial-scale=1\">\n";
    out += fmt::format("<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n<header><h1>{}</h1>\n",
                       html_escape(heading), report_style(), html_escape(heading));
    out += fmt::format(
        "<p class=\"soft\">ropsim {}: framebuffer operations simulated on captured fragments, judged "
        "against exact compositing.</p>\n",
        kVersion);
    if (comparisons.size() > 1) {
        out += "<nav>";
        for (std::size_t i = 0; i < comparisons.size(); ++i)
            out += fmt::format("<a href=\"#trace-{}\">{}</a>", i + 1, html_escape(comparisons[i].name));
        out += "</nav>\n";
    }
    out += "</header>\n<main>\n";
    for (std::size_t i = 0; i < comparisons.size(); ++i) out += section(comparisons[i], i);
    return out + "</main>\n</body>\n</html>\n";
}

void write_report(const std::vector<ComparisonOfOneTrace>& comparisons, const std::string& title,
                  const std::string& path) {
    write_file(path, report_html(comparisons, title));
}

}  // namespace ropsim
