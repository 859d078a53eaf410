// Ranking the points of the blue noise torus by void and cluster.
#include "rop/sampling/blue_noise.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>

namespace ropsim {
namespace {

constexpr int kSide = BlueNoise::kSide;
constexpr int kSlices = BlueNoise::kSlices;
constexpr int kArea = kSide * kSide;
constexpr int kRadius = 7;  // beyond it the energies are below 2^-9 of the largest
// Points a slice of the starting pattern, which is made even before it is ranked.
constexpr int kStartPoints = kArea / 32;
constexpr std::uint64_t kKey = 0x626C75656E6F6973ull;  // "bluenois"
// Added to the energy of a point that is set, above the sum of all repulsions: the lowest energy is always
// that of the largest void, the highest that of the tightest cluster.
constexpr std::int32_t kSet = 1 << 30;

// exp(-d / (2 sigma^2)) for squared distances d, sigma 1.9 as in Wolfe et al., with 20 bits of fraction.
// Products only, so that no library decides the values.
constexpr int kLargestSquare = 2 * kRadius * kRadius;
constexpr std::array<std::int32_t, kLargestSquare + 1> repulsions() {
    constexpr double kStep = 0.870660;  // exp(-1 / (2 1.9^2))
    std::array<std::int32_t, kLargestSquare + 1> table{};
    double value = 0x1p20;
    for (std::int32_t& entry : table) {
        entry = static_cast<std::int32_t>(value);
        value *= kStep;
    }
    return table;
}
constexpr std::array<std::int32_t, kLargestSquare + 1> kRepulsions = repulsions();
constexpr std::int32_t repulsion(int dx, int dy) {
    return kRepulsions[static_cast<std::size_t>(dx * dx + dy * dy)];
}

constexpr int wrap(int coordinate) {
    static_assert(kSide == kSlices);
    return coordinate & (kSide - 1);
}

// The torus: energies of all points, and per row of pixels the lowest, found again only when it has moved.
class Torus {
 public:
    Torus() : energy_(static_cast<std::size_t>(kArea) * kSlices), lowest_(std::size_t{kSide} * kSlices) {}

    bool is_set(int slice, int pixel) const { return at(slice, pixel) >= kSet; }
    void set(int slice, int pixel) { change<1>(slice, pixel); }
    void clear(int slice, int pixel) {
        change<-1>(slice, pixel);
        // Energies fell, perhaps below their rows' lowest.
        std::ranges::fill(lowest_, Lowest{});
    }
    int largest_void(int slice) {
        int best_row = 0;
        for (int row = 0; row < kSide; ++row) {
            Lowest& lowest = lowest_of(slice, row);
            if (lowest.column < 0) find_lowest(slice, row, lowest);
            if (lowest.energy < lowest_of(slice, best_row).energy) best_row = row;
        }
        return best_row * kSide + lowest_of(slice, best_row).column;
    }
    int tightest_cluster(int slice) const {
        const std::int32_t* energies = &energy_[static_cast<std::size_t>(slice) * kArea];
        return static_cast<int>(std::max_element(energies, energies + kArea) - energies);
    }

 private:
    struct Lowest {
        int column = -1;  // -1: not known
        std::int32_t energy = 0;
    };

    std::int32_t at(int slice, int pixel) const {
        return energy_[static_cast<std::size_t>(slice) * kArea + static_cast<std::size_t>(pixel)];
    }
    std::int32_t& at(int slice, int pixel) {
        return energy_[static_cast<std::size_t>(slice) * kArea + static_cast<std::size_t>(pixel)];
    }
    Lowest& lowest_of(int slice, int row) {
        return lowest_[static_cast<std::size_t>(slice) * kSide + static_cast<std::size_t>(row)];
    }
    void find_lowest(int slice, int row, Lowest& lowest) const {
        const std::int32_t* energies = &energy_[static_cast<std::size_t>(slice * kSide + row) * kSide];
        std::int32_t energy = energies[0];
        for (int x = 1; x < kSide; ++x) energy = std::min(energy, energies[x]);
        lowest = {static_cast<int>(std::find(energies, energies + kSide, energy) - energies), energy};
    }

    // Adds (kSign 1) or removes (-1) the point and its repulsion.
    template <int kSign>
    void change(int slice, int pixel) {
        const int x = pixel % kSide;
        const int y = pixel / kSide;
        at(slice, pixel) += kSign * kSet;
        for (int dy = -kRadius; dy <= kRadius; ++dy) {
            const int row = wrap(y + dy);
            std::int32_t* energies = &energy_[static_cast<std::size_t>(slice * kSide + row) * kSide];
            for (int dx = -kRadius; dx <= kRadius; ++dx) energies[wrap(x + dx)] += kSign * repulsion(dx, dy);
            Lowest& lowest = lowest_of(slice, row);
            if (wrap(lowest.column - x + kRadius) <= 2 * kRadius) lowest.column = -1;
        }
        for (int dt = -kRadius; dt <= kRadius; ++dt) {
            if (dt == 0) continue;
            const int other = wrap(slice + dt);
            at(other, pixel) += kSign * repulsion(dt, 0);
            Lowest& lowest = lowest_of(other, y);
            if (lowest.column == x) lowest.column = -1;
        }
    }

    std::vector<std::int32_t> energy_;  // slice, y, x
    std::vector<Lowest> lowest_;        // slice, y
};

std::uint32_t draw_below(std::uint32_t limit, std::uint64_t key, std::uint32_t draw) {
    return static_cast<std::uint32_t>((std::uint64_t{random_bits(key, draw)} * limit) >> 32);
}

// All slices in an order of the round's own.
std::array<int, kSlices> turns(int round) {
    std::array<int, kSlices> order{};
    std::iota(order.begin(), order.end(), 0);
    const std::uint64_t key = mix64(kKey + 1 + static_cast<std::uint64_t>(round));
    for (std::uint32_t left = kSlices; left > 1; --left)
        std::swap(order[left - 1], order[draw_below(left, key, left)]);
    return order;
}

// The same number of points in every slice, first at random, then moved, in each slice the tightest cluster
// to the largest void, until that is where it came from.
void start_evenly(Torus& torus) {
    std::uint32_t draw = 0;
    for (int slice = 0; slice < kSlices; ++slice)
        for (int count = 0; count < kStartPoints;) {
            const auto pixel = static_cast<int>(draw_below(kArea, kKey, draw++));
            if (torus.is_set(slice, pixel)) continue;
            torus.set(slice, pixel);
            ++count;
        }
    // A slice at rest may be disturbed by its neighbours in time: as many passes as points bound the work.
    bool moved = true;
    for (int pass = 0; moved && pass < kStartPoints; ++pass) {
        moved = false;
        for (int slice = 0; slice < kSlices; ++slice) {
            const int from = torus.tightest_cluster(slice);
            torus.clear(slice, from);
            const int to = torus.largest_void(slice);
            torus.set(slice, to);
            moved = moved || to != from;
        }
    }
}

// Rank of every point: the order in which the slices, taking turns, set their points.
std::vector<std::uint32_t> ranks() {
    std::vector<std::uint32_t> rank(static_cast<std::size_t>(kArea) * kSlices);
    const auto give = [&](int round, std::size_t turn, int slice, int pixel) {
        rank[static_cast<std::size_t>(slice) * kArea + static_cast<std::size_t>(pixel)] =
            static_cast<std::uint32_t>(round) * kSlices + static_cast<std::uint32_t>(turn);
    };
    Torus torus;
    start_evenly(torus);
    Torus start = torus;
    for (int round = kStartPoints - 1; round >= 0; --round) {
        const std::array<int, kSlices> order = turns(round);
        for (std::size_t turn = kSlices; turn-- > 0;) {
            const int pixel = start.tightest_cluster(order[turn]);
            start.clear(order[turn], pixel);
            give(round, turn, order[turn], pixel);
        }
    }
    for (int round = kStartPoints; round < kArea; ++round) {
        const std::array<int, kSlices> order = turns(round);
        for (std::size_t turn = 0; turn < kSlices; ++turn) {
            const int pixel = torus.largest_void(order[turn]);
            torus.set(order[turn], pixel);
            give(round, turn, order[turn], pixel);
        }
    }
    return rank;
}

}  // namespace

BlueNoise::BlueNoise() {
    const std::vector<std::uint32_t> rank = ranks();
    thresholds_.resize(rank.size());
    // (rank + 1/2) 2^32 / 2^18
    for (std::size_t slice = 0; slice < kSlices; ++slice)
        for (std::size_t pixel = 0; pixel < kArea; ++pixel)
            thresholds_[pixel * kSlices + slice] = (2 * rank[slice * kArea + pixel] + 1) << 13;
}

const BlueNoise& BlueNoise::instance() {
    static const BlueNoise noise;
    return noise;
}

}  // namespace ropsim
