// Which pixels a report's inspector knows.
#include "analysis/report/report_inspector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr int kDeepest = 6;      // pixels
constexpr int kApart = 24;       // pixels between two of them, in either direction
constexpr int kGridAcross = 24;  // cells of the finest grid

using Channels = std::array<int, 3>;

class Choice {
 public:
    Choice(const Image& reference, const std::vector<InspectedRun>& runs)
        : reference_(reference), runs_(runs), layers_(reference.channel("layers")) {}

    void add(PixelPlace place, const std::string& why) {
        if (taken_.insert(place).second) chosen_.push_back({place, why});
    }
    bool covered(int x, int y) const { return layers_ >= 0 && reference_.pixel(x, y)[layers_] > 0; }

    void add_deepest() {
        std::vector<PixelPlace> found;
        const auto apart = [&](int x, int y) {
            return std::none_of(found.begin(), found.end(), [&](const PixelPlace& other) {
                return std::abs(other.x - x) < kApart && std::abs(other.y - y) < kApart;
            });
        };
        for (int n = 0; n < kDeepest; ++n) {
            PixelPlace best;
            float most = 0;
            for (int y = 0; y < reference_.height; ++y)
                for (int x = 0; x < reference_.width; ++x) {
                    const float layers = reference_.pixel(x, y)[layers_];
                    if (layers > most && apart(x, y)) {
                        most = layers;
                        best = {x, y};
                    }
                }
            if (most <= 0) return;
            found.push_back(best);
            add(best, n == 0 ? "the deepest pixel" : "one of the deepest");
        }
    }

    void add_worst() {
        for (const InspectedRun& run : runs_) {
            const Channels a{run.image->channel("R"), run.image->channel("G"), run.image->channel("B")};
            const Channels b{reference_.channel("R"), reference_.channel("G"), reference_.channel("B")};
            PixelPlace best;
            double most = 0;
            for (int y = 0; y < reference_.height; ++y)
                for (int x = 0; x < reference_.width; ++x) {
                    if (!covered(x, y)) continue;
                    double error = 0;
                    for (std::size_t c = 0; c < 3; ++c) {
                        const double d = static_cast<double>(run.image->pixel(x, y)[a[c]]) -
                                         static_cast<double>(reference_.pixel(x, y)[b[c]]);
                        error += std::isfinite(d) ? d * d : 0;
                    }
                    if (error > most) {
                        most = error;
                        best = {x, y};
                    }
                }
            if (most > 0) add(best, fmt::format("where {} errs most", run.technique));
        }
    }

    // The covered pixel nearest to the middle of each cell and away from the others, cells of every fourth
    // line and column first.
    void add_grid() {
        const int cell = std::max(1, (reference_.width + kGridAcross - 1) / kGridAcross);
        for (int step = 4; step >= 1; step /= 2)
            for (int y = cell * step / 2; y < reference_.height; y += cell * step)
                for (int x = cell * step / 2; x < reference_.width; x += cell * step)
                    add_near(x, y, cell / 2);
    }

    std::vector<ChosenPixel> chosen() { return std::move(chosen_); }

 private:
    bool alone(int x, int y, int reach) const {
        return std::none_of(chosen_.begin(), chosen_.end(), [&](const ChosenPixel& other) {
            return std::abs(other.place.x - x) < reach && std::abs(other.place.y - y) < reach;
        });
    }
    void add_near(int x, int y, int reach) {
        for (int r = 0; r <= reach; ++r)
            for (int v = std::max(0, y - r); v <= std::min(reference_.height - 1, y + r); ++v)
                for (int u = std::max(0, x - r); u <= std::min(reference_.width - 1, x + r); ++u) {
                    if (std::max(std::abs(u - x), std::abs(v - y)) != r || !covered(u, v) ||
                        !alone(u, v, reach))
                        continue;
                    add({u, v}, "on the grid");
                    return;
                }
    }

    const Image& reference_;
    const std::vector<InspectedRun>& runs_;
    int layers_;
    std::set<PixelPlace> taken_;
    std::vector<ChosenPixel> chosen_;
};

}  // namespace

std::vector<ChosenPixel> chosen_pixels(const Image& reference, const std::vector<InspectedRun>& runs,
                                       const std::vector<PixelPlace>& asked) {
    Choice choice(reference, runs);
    for (const PixelPlace& place : asked) choice.add(place, "asked for");
    if (reference.channel("layers") >= 0) {
        choice.add_deepest();
        choice.add_worst();
        choice.add_grid();
    }
    return choice.chosen();
}

}  // namespace ropsim
