// What the pixel inspector of a report shows: chosen pixels' fragments, every technique's visibility at them
// against the exact one, what it has stored, and its colour.
#pragma once

#include "analysis/pixel_run.h"
#include "analysis/report/report_page.h"
#include "traces/image.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// A technique's image of the frame, R, G, B.
struct InspectedRun {
    std::string technique;
    std::uint64_t seed = 0;
    const Image* image = nullptr;
    std::string only_in_frame =
        {};  // why one pixel's fragments do not give what the frame did; empty: they do
};

struct ChosenPixel {
    PixelPlace place;
    std::string why;  // in a few words
};

// Pixels worth a look, the most telling first: those asked for, the deepest (a few, apart from each other),
// where each technique errs most, and over the whole image on a grid that gets finer; all but the first kind
// have a visible fragment (channel "layers" of the reference). None twice.
std::vector<ChosenPixel> chosen_pixels(const Image& reference, const std::vector<InspectedRun>& runs,
                                       const std::vector<PixelPlace>& asked);

// A block of data a pixel, as many as fit into `bytes` in their order, those asked for always; then, under
// `id`, the list of them. Pixels without a visible fragment are left out, unless asked for. Throws UserError
// for a faulty trace.
std::vector<ReportData> inspector_data(const std::string& id, const std::string& trace,
                                       const Image& reference, const std::vector<InspectedRun>& runs,
                                       const std::vector<ChosenPixel>& pixels, std::size_t asked,
                                       std::size_t bytes, int threads);

}  // namespace ropsim
