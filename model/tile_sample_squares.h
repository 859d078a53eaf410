// From the sampled partitions to all of them: sums over squares of tiles, estimated with what is known of
// every square.
#pragma once

#include "model/estimate.h"
#include "model/surface_map.h"
#include "traces/trace.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

// A square is what a partition owns in one piece (rop.partition_tiles on a side). Known of each without
// running anything: its fragments and its tiles that have some. A quantity's sum over all squares is
// estimated by its regression on the two (weights 1 / fragments, so that residuals of the sample sum to
// nought). Partitions interleave on the screen, so what varies slowly over it is the same in all of them: the
// variance between partitions is that of a square's residual against its nearest neighbours in the sample,
// which are farther away than the squares of the other partitions.
class SampleSquares {
 public:
    SampleSquares(const SurfaceMap& map, const TraceReader& trace, std::uint32_t square_tiles,
                  const std::vector<int>& sampled);

    std::size_t size() const { return fragments_.size(); }
    std::size_t square_of(std::size_t tile) const { return square_of_[tile]; }
    bool sampled(std::size_t square) const { return sampled_[square] != 0; }

    struct Fit {
        double per_fragment = 0;
        double per_tile = 0;
        double variance = 0;  // of the residuals' sum over one partition's squares
        double degrees = 0;   // effective, by Satterthwaite
    };
    // `values`: by square; those of squares outside the sample are not looked at.
    Fit fit(const std::vector<double>& values) const;
    // The sum over all squares.
    Estimate total(const std::vector<double>& values) const;
    // Of a count whose squares are not known: `counted` of the sample's `of`, as if all of a square's were
    // alike.
    Estimate total_of_count(double counted) const;
    // What the fit says of a partition.
    double predicted(const Fit& fit, int partition) const;
    int partitions() const { return static_cast<int>(partition_fragments_.size()); }
    double sampled_partitions() const { return static_cast<double>(sample_size_); }
    double fragments(int partition) const {
        return partition_fragments_[static_cast<std::size_t>(partition)];
    }
    double sample_fragments() const { return sample_fragments_; }
    double all_fragments() const { return all_fragments_; }

 private:
    static constexpr std::size_t kNeighbours = 4;
    void find_neighbours(std::size_t squares_across);
    // The variance between sums over partitions, from that of one partition's sum: expanded to all.
    double expanded(double variance) const;

    std::vector<std::size_t> square_of_;  // by tile
    std::vector<std::uint8_t> sampled_;   // by square
    std::vector<double> fragments_;       // by square
    std::vector<double> tiles_;           // by square: those with fragments
    std::vector<std::size_t> used_;       // squares of the sample with fragments
    std::vector<std::array<std::size_t, kNeighbours>>
        near_;  // of each of these, in `used_`; its own number: none
    std::vector<double> partition_fragments_;
    std::vector<double> partition_tiles_;
    std::size_t sample_size_ = 0;
    double sample_fragments_ = 0;
    double all_fragments_ = 0;
};

}  // namespace ropsim
