// The picture of a convergence study: error against the parameter on logarithmic axes, drawn by gnuplot.
#pragma once

#include "analysis/convergence.h"
#include "analysis/gnuplot.h"

#include <string>

namespace ropsim {

// Whether some technique has a value with an error above 0: others have no place on a logarithmic axis.
bool has_plot(const Convergence& convergence);

// gnuplot's commands for both files. Mean error over seeds with bars of one standard deviation, each
// technique's power law, and guides of slope -1/2 and -1.
std::string convergence_plot_script(const Convergence& convergence, const std::string& svg,
                                    const std::string& png);

// Writes DIRECTORY/convergence.svg (900 pixels wide) and convergence.png (1800), each atomically; the
// directory exists. Needs has_plot (CHECK). Throws UserError when gnuplot is missing or fails.
void write_convergence_plot(const Convergence& convergence, const std::string& directory);

}  // namespace ropsim
