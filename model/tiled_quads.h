// The quads of a frame as a tile-based machine comes to them: binning, then tile by tile every pass of the
// technique, from the load of the tile to its store.
#pragma once

#include "model/frame.h"
#include "model/tiled_bins.h"
#include "model/tiled_report.h"

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

namespace ropsim {

// Fits the machine to a technique on a trace: a tile is what a partition owns, operands come from tile
// memory. Returns what is binned, for which the machine has memory then.
TileBins prepare_tiled(TraceReader& trace, const Declaration& declaration, MachineConfig& config);

// Each partition has its tiles in order, quads in order of tile, pass and trace; partitions take turns, quad
// by quad. What is kept of quads that were run ahead is bounded.
class TiledQuads {
 public:
    // All must outlive it. `frame` must record quads and be at its start; nobody else may advance it.
    TiledQuads(Frame& frame, TraceReader& trace, const MachineConfig& config, const TileBins& bins);
    ~TiledQuads();

    // Replaces the batch by the next quads; false at the end of the frame.
    bool advance(QuadBatch& batch);
    // After the last advance().
    const TiledReport& report() const { return report_; }

 private:
    enum class Stage : std::uint8_t { kBinning, kTiles, kRest, kDone };
    // Quads that are kept until they are handed out.
    struct Kept {
        QuadBatch batch;
        std::uint64_t left = 0;
        std::uint64_t memory = 0;  // bytes, about
    };
    // Consecutive quads of one partition.
    struct Segment {
        Kept* kept;
        std::uint32_t first;
        std::uint32_t count;
    };
    // Consecutive quads of one tile, as the frame made them.
    struct Run {
        Segment segment;
        bool begins_pass;  // over the fragments
    };

    bool advance_binning(QuadBatch& batch);
    bool advance_tiles(QuadBatch& batch);
    bool advance_rest(QuadBatch& batch);
    bool wants_group() const;
    void run_group();
    void sort_runs(Kept& kept);
    void append_tile(std::size_t rank, const TileGroup& group, Kept& extra);
    void load_tile(std::size_t small_tile, QuadBatch& batch);
    void load_surface(int surface, std::size_t small_tile, QuadBatch& batch);
    void append_reads(std::uint32_t tile, std::uint8_t pass, QuadBatch& batch);
    void spread(Kept& extra, std::size_t first);
    void push(const Segment& segment);
    void hand_out(Segment& segment, QuadBatch& batch);
    Kept& take_kept();
    void prepare(QuadBatch& batch) const;

    Frame& frame_;
    TraceReader& trace_;
    const MachineConfig& config_;
    const TileBins& bins_;
    const SurfaceMap& map_;
    LineCollector collector_;
    Stage stage_ = Stage::kBinning;
    std::vector<std::vector<std::uint32_t>> groups_;
    std::size_t next_group_ = 0;
    std::size_t binned_ = 0;                    // lines of the bins written by every partition
    std::vector<std::deque<Segment>> streams_;  // by partition
    std::uint64_t kept_bytes_ = 0;
    std::vector<std::unique_ptr<Kept>> owned_;
    std::vector<Kept*> free_;
    std::vector<std::uint32_t> rank_;     // by 8x8 tile: in the group that is run
    std::vector<std::vector<Run>> runs_;  // by rank
    std::vector<int> pass_of_tile_;       // by rank: pass over the fragments that it was last in
    std::vector<Segment> tail_;           // of a stream, while something is spread over it
    QuadBatch waiting_;                   // of the rest, while bins are read
    bool has_waiting_ = false;
    std::uint32_t read_next_ = 0;  // tile whose bin is read next for it
    int last_pass_ = -1;           // of the rest
    TiledReport report_;
};

}  // namespace ropsim
