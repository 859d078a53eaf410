// gnuplot as a child process.
#include "analysis/gnuplot.h"

#include "analysis/child_process.h"
#include "base/atomic_file.h"
#include "base/error.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

namespace ropsim {

namespace fs = std::filesystem;

std::string gnuplot_program() {
    const char* const path = std::getenv("PATH");
    std::istringstream directories(path != nullptr ? path : "");
    for (std::string directory; std::getline(directories, directory, ':');) {
        std::string program = (fs::path(directory) / "gnuplot").string();
        if (::access(program.c_str(), X_OK) == 0 && fs::is_regular_file(program)) return program;
    }
    throw UserError("gnuplot", "is not installed and draws the plot; install the package gnuplot-nox");
}

std::string gnuplot_quoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) {
        if (c == '\'') result += '\'';
        result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
    return result + "'";
}

std::string svg_terminal(double width, double height, const std::string& file) {
    return fmt::format(
        "set terminal svg noenhanced rounded size {},{} dynamic background rgb 'white' font 'DejaVu "
        "Sans,14'\nset "
        "output {}\n",
        width, height, gnuplot_quoted(file));
}

std::string png_terminal(double width, double height, const std::string& file) {
    return fmt::format(
        "set terminal pngcairo noenhanced rounded size {},{} background rgb 'white' font 'DejaVu Sans,14' "
        "fontscale "
        "1.5 "
        "linewidth 2 pointscale 2\nset output {}\n",
        2 * width, 2 * height, gnuplot_quoted(file));
}

std::string log_tics(double low, double high) {
    if (!(low > 0 && low <= high && std::isfinite(high))) return {};  // an axis without points
    const double span = high / low;
    const std::vector<int> digits = span < 8       ? std::vector{1, 2, 3, 4, 5, 6, 8}
                                    : span < 20000 ? std::vector{1, 2, 5}
                                                   : std::vector{1};
    std::string tics;
    for (int power = static_cast<int>(std::floor(std::log10(low)));
         power <= static_cast<int>(std::ceil(std::log10(high))); ++power)
        for (const int digit : digits) {
            const double tic = digit * std::pow(10.0, power);
            if (tic < low || tic > high) continue;
            tics += fmt::format("{}'{:g}' {:g}", tics.empty() ? "" : ", ", tic, tic);
        }
    return tics;
}

void draw_plot(const std::string& directory, const std::string& name,
               const std::function<std::string(const std::string& svg, const std::string& png)>& script) {
    // Absolute: gnuplot takes a name that begins with '|' for a command.
    const fs::path folder = fs::absolute(directory);
    AtomicFile svg((folder / (name + ".svg")).string());
    AtomicFile png((folder / (name + ".png")).string());
    AtomicFile commands(
        (folder / (name + ".gnuplot")).string());  // never committed: goes away with this call
    write_file(commands.temporary_path(), script(svg.temporary_path(), png.temporary_path()));
    // -d: nobody's own settings.
    const ChildResult drawn = run_child({gnuplot_program(), "-d", commands.temporary_path()});
    if (!drawn.failure().empty())
        throw UserError("gnuplot", fmt::format("cannot draw the plot: {}", drawn.failure()));
    svg.commit();
    png.commit();
}

}  // namespace ropsim
