// Where the names of points go in a plot, so that they cover neither each other nor points.
#pragma once

#include <string>
#include <vector>

namespace ropsim {

// All in one unit (pixels), y up.
struct PicturePoint {
    double x = 0;
    double y = 0;
};
struct PlotBox {
    double left = 0, bottom = 0, right = 0, top = 0;
};
struct NamedPoint {
    PicturePoint at;
    double width = 0;  // of its name
    double height = 0;
};

// What names keep off: all points of the plot, named ones too, each `mark_radius` around, and, where there is
// room, a line through `line`.
struct PlotObstacles {
    std::vector<PicturePoint> marks;
    double mark_radius = 1;
    std::vector<PicturePoint> line;
};

// A box for each name: inside `area` where it fits, off the other names and the obstacles as far as there is
// room, near its point. Same input, same boxes.
std::vector<PlotBox> place_names(const PlotBox& area, const PlotObstacles& obstacles,
                                 const std::vector<NamedPoint>& names);

// The point of a box nearest to `p`: where a line from the name to its point starts.
PicturePoint nearest_of(const PlotBox& box, const PicturePoint& p);

}  // namespace ropsim
