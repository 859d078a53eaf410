// Each name takes the best of a fixed set of places around its point; then all are moved in turn until none
// gains. (An annealer finds little more on a dozen names.)
#include "analysis/label_placement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ropsim {
namespace {

constexpr double kCoveredName = 40;   // and as much again in proportion to what is covered
constexpr double kCoveredMark = 6;    // each
constexpr double kCoveredLine = 1.5;  // each piece of it
constexpr double kCrossedName = 8;    // by the line to a point
constexpr double kPerPixel = 0.03;    // of distance to the point
constexpr int kRounds = 12;

double overlap(const PlotBox& a, const PlotBox& b) {
    const double wide = std::min(a.right, b.right) - std::max(a.left, b.left);
    const double high = std::min(a.top, b.top) - std::max(a.bottom, b.bottom);
    return wide > 0 && high > 0 ? wide * high : 0;
}

double area_of(const PlotBox& box) {
    return (box.right - box.left) * (box.top - box.bottom);
}

double distance(const PicturePoint& a, const PicturePoint& b) {
    return std::hypot(a.x - b.x, a.y - b.y);
}

// Whether a straight line meets the box: what is left of it once it is cut at the four sides.
bool crosses(const PicturePoint& from, const PicturePoint& to, const PlotBox& box) {
    double enter = 0, leave = 1;
    const auto cut = [&](double start, double step, double low, double high) {
        if (step == 0) {
            if (start <= low || start >= high) leave = -1;
            return;
        }
        enter = std::max(enter, ((step > 0 ? low : high) - start) / step);
        leave = std::min(leave, ((step > 0 ? high : low) - start) / step);
    };
    cut(from.x, to.x - from.x, box.left, box.right);
    cut(from.y, to.y - from.y, box.bottom, box.top);
    return enter < leave;
}

// Places around a point: beside it, above and below, then rings further out.
std::vector<PlotBox> candidates(const PlotBox& area, double mark_radius, const NamedPoint& name) {
    std::vector<PlotBox> boxes;
    for (const double radius : {1.5, 3.0, 5.0, 8.0, 12.0, 16.0, 21.0, 27.0, 34.0}) {
        const double r = radius * mark_radius;
        for (int step = 0; step < 24; ++step) {
            const double angle = 2 * 3.14159265358979 * step / 24;
            const double c = std::cos(angle);
            const double s = std::sin(angle);
            // The box touches the ring with the side or corner that faces the point.
            const double x = name.at.x + r * c + name.width * (c - 1) / 2;
            const double y = name.at.y + r * s + name.height * (s - 1) / 2;
            const PlotBox box{x, y, x + name.width, y + name.height};
            if (box.left >= area.left && box.right <= area.right && box.bottom >= area.bottom &&
                box.top <= area.top)
                boxes.push_back(box);
        }
    }
    if (boxes.empty()) {
        const double x =
            std::clamp(name.at.x - name.width / 2, area.left, std::max(area.left, area.right - name.width));
        const double y = std::clamp(name.at.y + 1.5 * mark_radius, area.bottom,
                                    std::max(area.bottom, area.top - name.height));
        boxes.push_back({x, y, x + name.width, y + name.height});
    }
    return boxes;
}

struct Cost {
    const PlotObstacles& obstacles;
    const std::vector<NamedPoint>& names;
    const std::vector<PlotBox>& placed;

    double operator()(std::size_t self, const PlotBox& box, std::size_t among) const {
        double cost = kPerPixel * distance(nearest_of(box, names[self].at), names[self].at);
        for (const PicturePoint& mark : obstacles.marks)
            if (distance(nearest_of(box, mark), mark) < obstacles.mark_radius) cost += kCoveredMark;
        for (std::size_t i = 1; i < obstacles.line.size(); ++i)
            if (crosses(obstacles.line[i - 1], obstacles.line[i], box)) cost += kCoveredLine;
        const PicturePoint start = nearest_of(box, names[self].at);
        for (std::size_t other = 0; other < among; ++other) {
            if (other == self) continue;
            const double shared = overlap(box, placed[other]);
            if (shared > 0)
                cost += kCoveredName * (1 + shared / std::min(area_of(box), area_of(placed[other])));
            if (crosses(start, names[self].at, placed[other])) cost += kCrossedName;
            if (crosses(nearest_of(placed[other], names[other].at), names[other].at, box))
                cost += kCrossedName;
        }
        return cost;
    }
};

}  // namespace

PicturePoint nearest_of(const PlotBox& box, const PicturePoint& p) {
    return {std::clamp(p.x, box.left, box.right), std::clamp(p.y, box.bottom, box.top)};
}

std::vector<PlotBox> place_names(const PlotBox& area, const PlotObstacles& obstacles,
                                 const std::vector<NamedPoint>& names) {
    std::vector<std::vector<PlotBox>> places;
    for (const NamedPoint& name : names) places.push_back(candidates(area, obstacles.mark_radius, name));
    std::vector<PlotBox> placed(names.size());
    const Cost cost{obstacles, names, placed};
    const auto place = [&](std::size_t i, std::size_t among) {
        const PlotBox before = placed[i];
        double least = HUGE_VAL;
        for (const PlotBox& box : places[i]) {
            const double here = cost(i, box, among);
            if (here >= least) continue;
            least = here;
            placed[i] = box;
        }
        return placed[i].left != before.left || placed[i].bottom != before.bottom;
    };
    for (std::size_t i = 0; i < names.size(); ++i) place(i, i);
    for (int round = 0; round < kRounds; ++round) {
        bool moved = false;
        for (std::size_t i = 0; i < names.size(); ++i) moved = place(i, names.size()) || moved;
        if (!moved) break;
    }
    return placed;
}

}  // namespace ropsim
