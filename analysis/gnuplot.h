// Pictures drawn by gnuplot: the program, its texts, the looks of techniques, and files that appear complete.
#pragma once

#include <array>
#include <functional>
#include <string>

namespace ropsim {

// Path of gnuplot from PATH. Throws UserError naming its package when it is not installed.
std::string gnuplot_program();

// `text` in gnuplot's single quotes, in which nothing is replaced; control characters become spaces.
std::string gnuplot_quoted(const std::string& text);

// Told apart by the colour-blind (Okabe and Ito 2008) and, by their markers, in grey.
struct PlotLook {
    const char* color;
    int marker;  // gnuplot's point type, filled but for the last
};
inline constexpr std::array<PlotLook, 7> kPlotLooks = {{{"#0072B2", 7},
                                                        {"#D55E00", 5},
                                                        {"#009E73", 9},
                                                        {"#CC79A7", 13},
                                                        {"#E69F00", 11},
                                                        {"#56B4E9", 15},
                                                        {"#000000", 6}}};

// Commands that send what follows to `file`: an SVG of width x height pixels, and a PNG of twice as many.
std::string svg_terminal(double width, double height, const std::string& file);
std::string png_terminal(double width, double height, const std::string& file);

// Round numbers for a logarithmic axis from low to high > 0 as gnuplot's list of tics: the shorter the axis,
// the more of each decade.
std::string log_tics(double low, double high);

// Writes DIRECTORY/NAME.svg and NAME.png, each atomically; `script` gives the commands that draw the files it
// is told. The directory exists. Throws UserError when gnuplot is missing or fails.
void draw_plot(const std::string& directory, const std::string& name,
               const std::function<std::string(const std::string& svg, const std::string& png)>& script);

}  // namespace ropsim
