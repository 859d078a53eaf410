// The page, its tables and plots, and rows of other commands as sections.
#include "analysis/report/report_page.h"

#include "analysis/report/report_rows.h"
#include "analysis/report/report_widgets.h"
#include "base/error.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

std::size_t occurrences(const std::string& text, const std::string& what) {
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
    return count;
}

// The text of a data block as the browser's JSON.parse gets it.
Json data_of(const std::string& html, const std::string& id) {
    const std::string mark = "id=\"" + id + "\">";
    const std::size_t begin = html.find(mark) + mark.size();
    return Json::parse(html.substr(begin, html.find("</script>", begin) - begin));
}

TEST(ReportPage, HoldsSectionsDataAndScriptsOnce) {
    ReportPage page("A & B", "why <not>");
    ReportSection first{"one", "One <1>"};
    first += std::string("<p>text</p>");
    first += ReportWidget{"<div>widget</div>", {{"one-data", R"({"text": "</script><!--"})"}}};
    page.add(first);
    page.add({"two", "Two"});
    const std::string html = page.html();
    EXPECT_THAT(html, HasSubstr("<title>A &amp; B</title>"));
    EXPECT_THAT(html, HasSubstr("why &lt;not&gt;"));
    EXPECT_THAT(html, HasSubstr("<a href=\"#one\">One &lt;1&gt;</a>"));
    EXPECT_THAT(html, HasSubstr("<h2>One &lt;1&gt;</h2>\n<p>text</p><div>widget</div></section>"));
    EXPECT_EQ(occurrences(html, "Chart.js v3"), 1u) << "the library, with its notice";
    EXPECT_THAT(html, HasSubstr("Permission is hereby granted"));
    EXPECT_EQ(data_of(html, "one-data")["text"], "</script><!--") << "cannot end its element";
    EXPECT_EQ(occurrences(html, "<script"), occurrences(html, "</script>"));
}

TEST(ReportPage, OneSectionNeedsNoLinks) {
    ReportPage page("A", "");
    page.add({"one", "One"});
    EXPECT_THAT(page.html(), Not(HasSubstr("<nav")));
}

TEST(ReportPageDeathTest, IdentifiersAreUnique) {
    ReportPage page("A", "");
    page.add({"one", "One", "", {{"data", "1"}}});
    EXPECT_DEATH(page.add({"one", "Again"}), "one");
    EXPECT_DEATH(page.add({"two", "Two", "", {{"data", "2"}}}), "data");
}

TEST(ReportTable, IsPlainMarkupWithWhatScriptsNeed) {
    const std::string html =
        report_table({"t",
                      "caption",
                      {{"name"}, {"kind", CellKind::kChoice}, {"size", CellKind::kNumber, "B", "how large"}},
                      {{{"<a>"}, {"x"}, {"1 000", 1000.0}}, {{"b"}, {"y"}, {"–", {}, "none"}}}})
            .html;
    EXPECT_THAT(html, HasSubstr("<th scope=\"row\" class=\"left\">&lt;a&gt;</th>"));
    EXPECT_THAT(
        html, HasSubstr("data-kind=\"number\" data-name=\"size\" title=\"how large\">size<small>B</small>"));
    EXPECT_THAT(html, HasSubstr("<td data-value=\"1000\">1 000</td>"));
    EXPECT_THAT(html, HasSubstr("<td class=\"none\">–</td>"));
}

TEST(ReportPlot, KeepsMeasuredAxesOnly) {
    ReportPlot plot{"p",
                    "caption",
                    {{"error", "/255"}, {"cycles"}, {"speed", "", Better::kLarger}},
                    {"family"},
                    {{"a", {"one"}, {1.0, {}, 3.0}}, {"b", {"two"}, {2.0, {}, {}}}},
                    "cycles",
                    "error",
                    false,
                    true,
                    "ropsim x"};
    const ReportWidget widget = report_plot(plot);
    ASSERT_EQ(widget.data.size(), 1u);
    const Json json = Json::parse(widget.data[0].text);
    ASSERT_EQ(json["axes"].size(), 2u) << "nobody measured cycles";
    EXPECT_EQ(json["x"], "error") << "the one asked for is not there";
    EXPECT_EQ(json["y"], "error");
    EXPECT_EQ(json["axes"][1]["better"], "larger");
    EXPECT_EQ(json["points"][0]["values"], Json::parse("[1.0, 3.0]"));
    EXPECT_EQ(json["points"][1]["values"], Json::parse("[2.0, null]"));
    EXPECT_THAT(widget.html, HasSubstr("<code>ropsim x</code>"));
    EXPECT_THAT(widget.html, HasSubstr("<td data-value=\"3\">3</td>")) << "the numbers without scripts";
    plot.points[0].values[2] = {};
    EXPECT_EQ(report_plot(plot).html, "") << "one axis is no plot";
}

constexpr const char* kClaims = R"([
  {"id": "st-1", "paper": "ST 2011", "place": "5.1", "claim": "bytes <per> fragment", "printed": 30.5,
   "worst_case": 30, "measured": {"value": 12.25, "ci95": [12, 12.5]}, "verdict": "reproduced", "why": null},
  {"id": "at-1", "paper": "AT 2011", "claim": "text", "printed": "2x", "verdict": "does not follow from its own definition", "why": "because"},
  {"id": "at-2", "paper": "AT 2011", "verdict": "reproduced under bytes of 1e6", "why": "so"}])";

TEST(ClaimsReport, CountsVerdictsAndShowsEveryRow) {
    const std::string html = claims_report(kClaims, "ropsim claims --json");
    EXPECT_THAT(html, HasSubstr("<b>3</b> claims"));
    EXPECT_THAT(html, HasSubstr("<span class=\"good\"><b>1</b> reproduced</span>"));
    EXPECT_THAT(html,
                HasSubstr("<span class=\"bad\"><b>1</b> does not follow from its own definition</span>"));
    EXPECT_THAT(html, HasSubstr("bytes &lt;per&gt; fragment"));
    EXPECT_THAT(html, HasSubstr("<td data-value=\"12.25\">12.25 (12 to 12.5)</td>"));
    EXPECT_THAT(html, HasSubstr(">2x</td>"));
    EXPECT_THAT(html, HasSubstr("<td class=\"good left\">reproduced</td>"));
    EXPECT_THAT(html, HasSubstr("<td class=\"good left\">reproduced under a reading</td>"));
    EXPECT_THAT(html, HasSubstr("Under bytes of 1e6. so"));
    EXPECT_EQ(occurrences(html, "<th scope=\"row\""), 3u);
    EXPECT_THAT(html, HasSubstr("ropsim claims --json"));
}

TEST(ClaimsReport, RefusesWhatIsNoListOfRows) {
    for (const char* text : {"", "{}", "[1]", "[{]"})
        EXPECT_THROW(claims_report(text, ""), UserError) << text;
    EXPECT_THAT(claims_report("[]", ""), HasSubstr("<b>0</b> claims"));
}

TEST(BenchReport, FindsNamesGroupsAndAxes) {
    const std::string html = bench_report(
        R"({"plots": [{"title": "Runs", "x": "seconds", "y": "error",
            "columns": ["technique", "fidelity", "seconds", "error"],
            "rows": [["a", "count", 1, {"value": 2, "ci95": [1, 3]}], ["b", "timed", 3, null]]}]})",
        "ropsim bench");
    const Json json = data_of(html, "bench-plot-data");
    EXPECT_THAT(json["groupings"], ElementsAre("fidelity"));
    EXPECT_EQ(json["axes"][0]["name"], "seconds");
    EXPECT_EQ(json["axes"][1]["name"], "error");
    EXPECT_EQ(json["points"][0]["name"], "a");
    EXPECT_EQ(json["points"][0]["values"], Json::parse("[1.0, 2.0]"));
    EXPECT_EQ(json["points"][1]["values"], Json::parse("[3.0, null]"));
    EXPECT_EQ(json["points"][1]["groups"], Json::parse("[\"timed\"]"));
}

TEST(BenchReport, WithoutTwoNumbersIsATable) {
    const std::string html =
        bench_report(R"({"plots": [{"title": "Runs", "x": "seconds", "y": "", "columns": ["name", "seconds"],
                                 "rows": [["a", 1], ["b", 2]]}]})",
                     "x");
    EXPECT_THAT(html, Not(HasSubstr("class=\"plot\"")));
    EXPECT_THAT(html, HasSubstr("<td data-value=\"2\">2</td>"));
}

TEST(BenchReport, NamesPointsByTechniqueAndModeAndTakesEveryPlot) {
    const std::string html = bench_report(
        R"({"plots": [{"title": "One", "x": "s", "y": "e", "columns": ["technique", "mode", "s", "e"],
                       "rows": [["a", "count", 1, 2], ["a", "timed", 2, 1]]},
                      {"title": "Two", "x": "s", "y": "e", "columns": ["technique", "s", "e"],
                       "rows": [["b", 1, 2], ["c", 2, 1]]}]})",
        "x");
    EXPECT_EQ(data_of(html, "bench-plot-data")["points"][1]["name"], "a, timed");
    EXPECT_EQ(data_of(html, "bench-2-plot-data")["points"][0]["name"], "b");
    for (const char* text : {"", "{}", "[1]", R"({"plots": 1})", R"({"plots": [{"rows": [[1]]}]})"})
        EXPECT_THROW(bench_report(text, ""), UserError) << text;
}

}  // namespace
}  // namespace ropsim
