// Error against bytes as JSON, CSV, Markdown, and a picture.
#pragma once

#include "analysis/tradeoff.h"

#include <string>

namespace ropsim {

// One object with every number, "units" saying what each is in; what was not measured is null. Same inputs,
// same text. `plotted`: whether the pictures were drawn.
std::string tradeoff_json(const Tradeoff& tradeoff, bool plotted);
// One line a scene and technique under a heading; what was not measured is empty.
std::string tradeoff_csv(const Tradeoff& tradeoff);
// A table with a row a technique and a pair of columns a scene, those on its front in bold; below it what was
// refused, and why.
std::string tradeoff_markdown(const Tradeoff& tradeoff);

// Whether some scene has a technique with bytes to show.
bool has_plot(const Tradeoff& tradeoff);
// gnuplot's commands: a panel a scene, error over bytes on logarithmic axes, the front as a stepped line with
// its points named, the others by their family's marker. Errors of 0 stand on the panel's floor.
std::string tradeoff_plot_script(const Tradeoff& tradeoff, const std::string& svg, const std::string& png);
// Writes DIRECTORY/NAME.svg and NAME.png, each atomically. Needs has_plot (CHECK). Throws UserError when
// gnuplot is missing or fails.
void write_tradeoff_plot(const Tradeoff& tradeoff, const std::string& directory,
                         const std::string& name = "tradeoff");

}  // namespace ropsim
