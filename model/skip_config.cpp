#include "model/skip_config.h"

#include "base/error.h"

#include <sstream>

namespace ropsim {

namespace {

ScreenRegion read_region(Parameters& p) {
    const std::string text = p.get_string("skip.region", "");
    if (text.empty()) return {};
    std::istringstream words(text);
    ScreenRegion r;
    words >> r.x0 >> r.y0 >> r.x1 >> r.y1;
    const bool four = !words.fail() && (words >> std::ws).eof();
    if (!four || r.x0 < 0 || r.y0 < 0 || r.x1 <= r.x0 || r.y1 <= r.y0)
        throw UserError(p.where("skip.region"),
                        fmt::format("'{}' must be four pixel numbers \"x0 y0 x1 y1\" with 0 <= x0 < x1 and "
                                    "0 <= y0 < y1; x1 and y1 lie outside",
                                    text));
    return r;
}

}  // namespace

SkipConfig read_skips(Parameters& p) {
    SkipConfig skip;
    skip.untouched_tiles = p.get_flag("skip.untouched_tiles", skip.untouched_tiles);
    skip.zero_alpha = p.get_flag("skip.zero_alpha", skip.zero_alpha);
    skip.occluded = p.get_flag("skip.occluded", skip.occluded);
    skip.saturated = p.get_flag("skip.saturated", skip.saturated);
    skip.region = read_region(p);
    return skip;
}

}  // namespace ropsim
