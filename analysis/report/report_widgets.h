// Widgets of a report that know nothing of what they show: a table to filter and sort, a plot of points whose
// axes are picked on the page. Both are tables without scripts.
#pragma once

#include "analysis/report/report_page.h"
#include "analysis/run_record.h"

#include <string>
#include <vector>

namespace ropsim {

enum class CellKind {
    kText,    // found by the filter's text
    kChoice,  // few values: a menu picks one
    kNumber,  // right-aligned, sorted by value
};

struct ReportColumn {
    std::string heading;
    CellKind kind = CellKind::kText;
    std::string unit = {};     // below the heading
    std::string meaning = {};  // one line, for a pointer that rests on the heading
};

struct ReportCell {
    std::string text;        // plain
    Measured value = {};     // by which a number is sorted
    std::string style = {};  // class of the style sheet: good, bad or none
};

struct ReportTable {
    std::string id;  // unique in the page
    std::string caption;
    std::vector<ReportColumn> columns;          // the first names the row
    std::vector<std::vector<ReportCell>> rows;  // as long as `columns` each (CHECK)
};

// A search field, a menu a kChoice column, headings that sort; how many rows are shown.
ReportWidget report_table(const ReportTable& table);

enum class Better { kSmaller, kLarger, kNeither };

struct PlotAxis {
    std::string name;  // unique among the axes
    std::string unit = {};
    Better better = Better::kSmaller;  // says what the Pareto front is of
};

struct PlotPoint {
    std::string name;
    std::vector<std::string> groups = {};  // one a grouping of the plot
    std::vector<Measured> values;          // one an axis; a point without one of the picked is left out
};

struct ReportPlot {
    std::string id;  // unique in the page
    std::string caption;
    std::vector<PlotAxis> axes;
    std::vector<std::string> groupings = {};  // what points may be coloured by, e.g. technique, scene
    std::vector<PlotPoint> points;
    std::string x = {}, y = {};  // axes picked first; empty: the first two that are measured
    bool log_x = false, log_y = false;
    std::string command = {};  // that makes the numbers anew; may be empty
    std::string within = {};   // the grouping within which alone points compare; empty: all do
};

// What stands for a value that was not measured.
const char* report_absent();
// The line below a figure or table that says how to make it anew; empty for an empty command.
std::string report_command(const std::string& command);

// Menus of both axes and of colours, logarithmic scales where all values are positive, the points' names and
// values on hover and by the arrow keys, the Pareto front; the numbers as a table below. Empty where fewer
// than two axes are measured.
ReportWidget report_plot(const ReportPlot& plot);

}  // namespace ropsim
