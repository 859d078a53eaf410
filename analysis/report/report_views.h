// The picture viewer of a report: reference and techniques under a slider, differences, heat maps, the pixel
// inspector; and the cards that stand for it on paper.
#pragma once

#include "analysis/comparison.h"
#include "analysis/pixel_run.h"
#include "analysis/report/report_page.h"

#include <cstddef>
#include <string>
#include <vector>

namespace ropsim {

// What the pictures and the inspector of one page may take, as text of the page.
struct ReportBudget {
    std::size_t picture_bytes = 10'500'000;
    std::size_t inspector_bytes = 2'500'000;
};

// Reads image.exr and, where there is one, tiles.exr of every successful run; one that cannot be read is
// reported in its place. `id`: unique in the page. `inspect`: pixels to be known besides the chosen ones,
// inside the image (CHECK). Empty of a widget where no image can be read.
ReportWidget report_views(const ComparisonOfOneTrace& comparison, const std::string& id,
                          const std::vector<PixelPlace>& inspect, const ReportBudget& budget);

}  // namespace ropsim
