// Puts the sections of a page together with styles, scripts and library.
#include "analysis/report/report_page.h"

#include "analysis/html.h"
#include "analysis/report/report_resources.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/version.h"

#include <iterator>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Nothing is fetched, whatever a page holds: the browser enforces it.
constexpr std::string_view kPolicy =
    "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

// Text of a script element must not end it: "<" occurs in JSON's strings only, where it may be escaped.
std::string escaped_data(const std::string& text) {
    std::string out;
    out.reserve(text.size());
    for (const char c : text) {
        if (c == '<')
            out += "\\u003c";
        else
            out += c;
    }
    return out;
}

std::string links(const std::vector<ReportSection>& sections) {
    if (sections.size() < 2) return {};
    std::string out = "<nav aria-label=\"Sections\">";
    for (const ReportSection& section : sections)
        out += fmt::format("<a href=\"#{}\">{}</a>", html_escape(section.id), html_escape(section.heading));
    return out + "</nav>\n";
}

}  // namespace

ReportSection& ReportSection::operator+=(const std::string& markup) {
    html += markup;
    return *this;
}

ReportSection& ReportSection::operator+=(ReportWidget widget) {
    html += widget.html;
    data.insert(data.end(), std::make_move_iterator(widget.data.begin()),
                std::make_move_iterator(widget.data.end()));
    return *this;
}

ReportPage::ReportPage(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void ReportPage::add(ReportSection section) {
    std::set<std::string> taken;
    for (const ReportSection& other : sections_) {
        taken.insert(other.id);
        for (const ReportData& data : other.data) taken.insert(data.id);
    }
    CHECK(taken.insert(section.id).second, "section {} is there already", section.id);
    for (const ReportData& data : section.data)
        CHECK(taken.insert(data.id).second, "data {} of section {} are there already", data.id, section.id);
    sections_.push_back(std::move(section));
}

std::string ReportPage::html() const {
    std::string out = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n<link rel=\"icon\" href=\"data:,\">\n"
        "<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n<header><h1>{}</h1>\n",
        kPolicy, html_escape(title_), report_style(), html_escape(title_));
    out += fmt::format("<p class=\"soft\">ropsim {}{}{}</p>\n", kVersion, subtitle_.empty() ? "" : ": ",
                       html_escape(subtitle_));
    out += links(sections_) + "</header>\n<main>\n";
    out +=
        "<noscript><p class=\"note\">Pictures, plots and the pixel inspector need JavaScript, which is off; "
        "the tables are all here.</p></noscript>\n";
    for (const ReportSection& section : sections_)
        out += fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", html_escape(section.id),
                           html_escape(section.heading), section.html);
    out += fmt::format(
        "</main>\n<footer><details><summary>Plots by Chart.js</summary><pre>{}</pre></details></footer>\n",
        html_escape(report_library_license()));
    // Data last, so that text and tables are there while the rest is still read.
    for (const ReportSection& section : sections_)
        for (const ReportData& data : section.data)
            out += fmt::format("<script type=\"{}\" id=\"{}\">{}</script>\n", data.type, html_escape(data.id),
                               escaped_data(data.text));
    out += fmt::format("<script>{}</script>\n<script>\n{}</script>\n</body>\n</html>\n", report_library(),
                       report_scripts());
    return out;
}

void ReportPage::write(const std::string& path) const {
    write_file(path, html());
}

}  // namespace ropsim
