// Names in a plot: inside it, off each other, off points.
#include "analysis/label_placement.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr PlotBox kArea{50, 30, 750, 530};

bool overlap(const PlotBox& a, const PlotBox& b) {
    return std::min(a.right, b.right) > std::max(a.left, b.left) &&
           std::min(a.top, b.top) > std::max(a.bottom, b.bottom);
}

TEST(NamePlaces, KeepOffEachOtherAndOffPointsWhereThereIsRoom) {
    std::mt19937 random(3);
    const auto between = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random() % 1000) / 999;
    };
    int covered = 0;
    for (int round = 0; round < 30; ++round) {
        PlotObstacles obstacles{{}, 6, {}};
        std::vector<NamedPoint> names;
        // Half of the names crowd in a corner.
        for (int i = 0; i < 12; ++i) {
            const bool crowd = i % 2 == 0;
            const PicturePoint at{between(kArea.left, crowd ? kArea.left + 150 : kArea.right),
                                  between(crowd ? kArea.top - 150 : kArea.bottom, kArea.top)};
            obstacles.marks.push_back(at);
            names.push_back({at, 120, 14});
        }
        for (int i = 0; i < 20; ++i)
            obstacles.marks.push_back({between(kArea.left, kArea.right), between(kArea.bottom, kArea.top)});
        const std::vector<PlotBox> boxes = place_names(kArea, obstacles, names);
        ASSERT_EQ(boxes.size(), names.size());
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            EXPECT_NEAR(boxes[i].right - boxes[i].left, 120, 1e-9);
            EXPECT_NEAR(boxes[i].top - boxes[i].bottom, 14, 1e-9);
            EXPECT_GE(boxes[i].left, kArea.left);
            EXPECT_LE(boxes[i].right, kArea.right);
            EXPECT_GE(boxes[i].bottom, kArea.bottom);
            EXPECT_LE(boxes[i].top, kArea.top);
            for (std::size_t j = 0; j < i; ++j)
                EXPECT_FALSE(overlap(boxes[i], boxes[j])) << "round " << round << ": " << i << ", " << j;
            for (const PicturePoint& mark : obstacles.marks) {
                const PicturePoint near = nearest_of(boxes[i], mark);
                covered += std::hypot(near.x - mark.x, near.y - mark.y) < 6 ? 1 : 0;
            }
        }
    }
    EXPECT_LE(covered, 3);
}

TEST(NamePlaces, StayNearAPointThatIsAlone) {
    const std::vector<NamedPoint> names{{{400, 300}, 100, 14}};
    const PlotBox box = place_names(kArea, {{{400, 300}}, 6, {}}, names)[0];
    const PicturePoint near = nearest_of(box, {400, 300});
    EXPECT_LT(std::hypot(near.x - 400, near.y - 300), 12);
    EXPECT_GE(std::hypot(near.x - 400, near.y - 300), 6);
}

TEST(NamePlaces, KeepOffALine) {
    const std::vector<NamedPoint> names{{{400, 300}, 100, 14}};
    // From the point up and to the right.
    const PlotObstacles obstacles{{{400, 300}}, 6, {{400, 500}, {400, 300}, {700, 300}}};
    const PlotBox box = place_names(kArea, obstacles, names)[0];
    EXPECT_FALSE(box.left < 400 && box.right > 400 && box.top > 300);
    EXPECT_FALSE(box.bottom < 300 && box.top > 300 && box.right > 400);
}

TEST(NamePlaces, ANameThatFitsNowhereStillHasAPlace) {
    const std::vector<NamedPoint> names{{{60, 500}, 2000, 14}};
    const PlotBox box = place_names(kArea, {{{60, 500}}, 6, {}}, names)[0];
    EXPECT_EQ(box.left, kArea.left);
    EXPECT_TRUE(place_names(kArea, {}, {}).empty());
}

}  // namespace
}  // namespace ropsim
