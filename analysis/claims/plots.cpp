// Draws what rows bring.
#include "analysis/claims/plots.h"

#include "analysis/gnuplot.h"
#include "base/atomic_file.h"
#include "base/outputs.h"

namespace ropsim {

void write_claim_plots(const std::vector<ClaimResult>& results, const std::string& directory) {
    for (const ClaimResult& result : results) {
        const ClaimPlot& plot = result.finding.plot;
        if (plot.name.empty() || !result.failure.empty()) continue;
        start_directory(directory);
        write_file(directory + "/" + plot.name + ".csv", plot.csv);
        draw_plot(directory, plot.name, [&](const std::string& svg, const std::string& png) {
            return svg_terminal(plot.width, plot.height, svg) + plot.drawing +
                   png_terminal(plot.width, plot.height, png) + plot.drawing;
        });
    }
}

}  // namespace ropsim
