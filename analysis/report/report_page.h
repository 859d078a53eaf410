// A self-contained page made of sections: markup that reads without scripts and on paper, and blocks of data
// that the page's own scripts (report/*.js) make interactive. No server, no network.
//
//     ReportPage page("Claims", "what the papers print against what is measured");
//     ReportSection section{"claims", "Claims"};
//     section += report_table(table);       // analysis/report/report_widgets.h
//     section += report_plot(plot);
//     page.add(std::move(section));
//     page.write(directory + "/report.html");
#pragma once

#include <string>
#include <vector>

namespace ropsim {

// A block of data that a script of the page finds by its identifier and reads when it is needed.
struct ReportData {
    std::string id;
    std::string text;  // JSON, or a data: URI with type "text/plain"
    std::string type = "application/json";
};

// A piece of a section: its markup and the data that go with it.
struct ReportWidget {
    std::string html;
    std::vector<ReportData> data;
};

struct ReportSection {
    std::string id;       // of the page's elements: letters, digits and dashes, unique in the page
    std::string heading;  // plain text
    std::string html = {};
    std::vector<ReportData> data = {};

    ReportSection& operator+=(const std::string& markup);
    ReportSection& operator+=(ReportWidget widget);
};

class ReportPage {
 public:
    // Plain text; the subtitle may be empty.
    ReportPage(std::string title, std::string subtitle);

    // Sections stand in the order of their adding; with several a list of links leads to them. Their
    // identifiers and those of their data must differ (CHECK).
    void add(ReportSection section);
    std::string html() const;
    // Atomically. Throws UserError when the file cannot be written.
    void write(const std::string& path) const;

 private:
    std::string title_;
    std::string subtitle_;
    std::vector<ReportSection> sections_;
};

}  // namespace ropsim
