// The functional frame: culls, shards fragments by partition, runs the operations on all cores in trace
// order, and hands out what they did as quads. The image is defined here; timing only replays it.
#pragma once

#include "model/hierarchical_depth.h"
#include "model/line_collector.h"
#include "model/machine_config.h"
#include "model/quad_operation.h"
#include "model/surface_map.h"
#include "model/tile_group.h"
#include "rop/operation.h"
#include "rop/pass_sequence.h"
#include "traces/depth_test.h"
#include "traces/image.h"
#include "traces/trace.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace ropsim {

// Bytes of one surface, added up without caches.
struct SurfaceTraffic {
    std::uint64_t worst_read = 0;  // the largest over the control paths, for every operation
    std::uint64_t worst_write = 0;
    std::uint64_t read = 0;  // what the operations of this trace touched
    std::uint64_t write = 0;
};

struct FragmentCounts {
    std::uint64_t input = 0;         // of the trace, once
    std::uint64_t depth_culled = 0;  // behind the opaque layer, or covering no sample
    std::uint64_t zero_alpha = 0;    // dropped: zero alpha and colour, where that is harmless
    std::uint64_t operated = 0;      // reached the operation (in each pass)
    std::uint64_t between = 0;       // of draws at lower resolution: between its samples, not drawn
    std::uint64_t joined = 0;        // exported together with a later one, from the shader's registers
};

// Fragments in another order than the trace's. Within a pass each of the trace's fragments comes once.
class FragmentSource {
 public:
    virtual ~FragmentSource() = default;
    // The next chunk of a pass (Frame::pass_names()) with the channels wanted, before any depth test; false
    // at the pass's end. Each pass is asked for until its end.
    virtual bool next(FragmentChunk& chunk, unsigned wanted, std::uint8_t pass) = 0;
};

class Frame {
 public:
    // `quads`: also keep what timing needs. The trace and the operation must outlive the frame.
    Frame(TraceReader& trace, const FramebufferOperation& operation, const MachineConfig& config, int threads,
          bool quads);
    ~Frame();
    // Before the first advance(): only these tiles (selected[tile] != 0) are drawn to, initialised and
    // resolved; blocks of the trace without one of them are not decoded. Empty: all.
    void select_tiles(std::vector<std::uint8_t> selected);

    // Before the first advance(): takes fragments from `source`, which must outlive the frame, and not from
    // the trace.
    void take_fragments_from(FragmentSource& source) { source_ = &source; }
    // Before the first advance(): every pass decodes the trace anew. Otherwise a technique of several passes
    // keeps the fragments of the first for the others, as long as they take no more than 640 MiB.
    void keep_no_fragments() { keeps_ = false; }
    // For a frame that is run group of tiles by group of tiles (model/tiled_quads.h). Starts again from the
    // initial contents, up to the plan's last tiled pass, or to resolve if that is tiled; what was drawn
    // before stays, and counts go on. A tile whose repeated passes have nothing more to do is left out of
    // further rounds. `group` must outlive its last advance().
    void start_group(const TileGroup& group);
    // What is left after the last group: later passes and resolve, over the whole screen.
    void start_rest();
    // Passes run of the group so far, every round of a repeated one.
    int passes_in_group() const { return passes_run_; }
    // Of the trace's channels, those that fragments are asked for with.
    unsigned fragment_channels() const;
    // Appends the quad that writes a finished 8x8 tile's colours from tile memory to memory.
    void store_tile(std::size_t tile, QuadBatch& batch) const;

    // Runs the next stretch of the frame: some fragments of a pass, or some tiles of the initialise or
    // resolve stage. False at the end. With `quads`, `batch` (cleared here) gets the stretch's quads in
    // raster order.
    bool advance(QuadBatch& batch);
    // Passes run so far, every round of a repeated one.
    int passes_run() const { return std::max(passes_run_, most_passes_); }
    // Those of them that went over the transparent fragments.
    int geometry_passes_run() const { return std::max(geometry_passes_run_, most_geometry_passes_); }
    // What QuadBatch::pass stands for: the initial contents, the technique's passes with what they restore,
    // resolve, and what is left to move at the end of the frame.
    std::vector<std::string> pass_names() const;
    std::size_t draws() const { return trace_.header().draws.size(); }
    int width() const { return trace_.header().width; }    // pixels
    int height() const { return trace_.header().height; }  // pixels
    bool has_opaque_layer() const { return trace_.header().opaque.has_value(); }

    // A store of the frame's, for what a pixel starts with.
    const PixelStore& initial_pixels() const;
    const SurfaceMap& surfaces() const { return map_; }
    const CostTable& cost() const { return cost_; }
    const FramebufferOperation& operation() const { return operation_; }
    // After the last advance().
    const Image& image() const { return image_; }  // R, G, B; the opaque layer where no tile was touched
    FragmentCounts fragments() const { return counts_; }
    SkipCounts skipped() const { return skipped_; }
    std::vector<SurfaceTraffic> traffic() const;  // by surface of the map
    std::uint64_t path_count(std::size_t path) const;
    std::array<std::uint64_t, 2> path_steps(std::size_t path) const;
    std::uint64_t touched_tiles() const;
    std::uint64_t hierarchical_depth_bytes() const;  // on chip, of the image's tiles
    std::uint64_t pool_used() const;
    std::uint64_t pool_overflowed() const;
    const std::vector<std::uint8_t>& covered() const { return covered_; }  // pixels with a visible fragment
    const StoreMap& stores() const { return *stores_; }                    // the pixels' final state

 private:
    struct Shard;  // one partition's state
    // What the frame is at: the initial contents, then each pass with what it restores, then resolve.
    enum class Stage : std::uint8_t { kInitialise, kRestore, kGeometry, kImage, kResolve, kDone };
    bool advance_stage(QuadBatch& batch);
    std::uint8_t pass_number() const;
    std::vector<std::uint8_t> kept_values() const;
    void write_image_quad(LineCollector& collector, std::size_t tile, std::uint32_t quad) const;
    const std::uint8_t* stored_values(const PixelStore& store, int surface, std::size_t tile,
                                      std::uint32_t quad, std::uint32_t pixel, std::uint64_t elements,
                                      std::vector<std::uint8_t>& bytes) const;
    void next_stage();
    void enter_pass();
    bool advance_initialise(const std::vector<int>& surfaces, QuadBatch& batch);
    bool advance_geometry(QuadBatch& batch);
    bool advance_image_pass(QuadBatch& batch);
    bool advance_resolve(QuadBatch& batch);
    // Takes the next touched tiles into the shards, with `quads_each` quads of the batch for each tile.
    struct TileChoice {
        bool all = false;       // also those that nothing was drawn to
        bool allocate = false;  // the pixels' state, whether something was drawn to them or not
        int scale = 1;
    };
    std::size_t take_tiles(const TileChoice& choice, std::size_t quads_each, QuadBatch& batch);
    void emit_window_quads(std::size_t tile, QuadBatch& batch);
    void collect_quad(LineCollector& collector, int partition, int x, int y, const PathCost& path,
                      bool background) const;
    struct Chunk;
    bool advance_whole_chunk();
    void prepare_chunk();
    Chunk* read_chunk(Chunk& own);
    Chunk* next_chunk(Chunk& own);
    bool read_visible(Chunk& chunk);
    void prepare_chunks();
    bool keeps_chunks() const;
    bool alters_chunks() const;
    void bin_tiles();
    void sort_by_tile(Chunk& chunk);
    void forget_chunks();
    std::uint64_t keep_region(FragmentChunk& chunk) const;
    void choose_fragments(FragmentChunk& chunk);
    void hold_back_run(FragmentChunk& chunk);
    bool joins_next(const FragmentChunk& chunk, std::size_t i) const;
    bool read_group_chunk(FragmentChunk& chunk);
    void leave_out_finished_tiles(int round_before);
    void note_watched_path(std::size_t tile) { watched_taken_[config_.tiles.tile_of(tile)] = 1; }
    bool stops_here() const;
    std::uint64_t watched_count() const;
    std::vector<std::uint8_t> stored_tile(int surface, std::size_t tile) const;
    bool reached(std::size_t tile, int scale) const;
    bool selected(std::size_t tile) const { return selected_.empty() || selected_[tile] != 0; }
    bool low_resolution_reached(std::size_t tile) const;
    struct GatheredPixel;
    struct GatheredQuad;
    struct GatheredTile;
    void emit_gather_quads(QuadBatch& batch);
    void emit_gathered_quad(std::size_t tile, std::uint32_t number, const GatheredQuad& quad,
                            QuadBatch& batch);
    void emit_downsample_quads(std::size_t tile, int scale, QuadBatch& batch) const;
    void keep_gathered(Shard& shard, std::size_t tile) const;
    // Fragments whose depth is tested, and those of them whose depth is read for it.
    struct DepthTests {
        std::uint64_t tested = 0;
        std::uint64_t read = 0;
    };
    void sort_into_quads(const FragmentSpan& span, QuadBatch& batch);
    bool first_pass() const;
    void count(const FragmentCounts& seen, const DepthTests& tests);
    std::size_t tile_of(const Fragment& f) const;
    void look_up_draws();
    int tested_depth() const;
    const HierarchicalDepth* depth_ranges(int scale);
    QuadOperation& add_quad(const Fragment& f, QuadBatch& batch);
    void emit_pass_quads(Shard& shard, QuadBatch& batch);
    void check_region() const;
    ScreenRegion tile_region(std::size_t tile) const;
    void resolve_tile(Shard& shard, std::size_t tile, std::size_t first_quad, QuadBatch& batch);
    // Adds a pixel that a resolve or an image pass has gone over to its quad.
    void add_resolved(const PathCost& path, const std::array<std::uint32_t, 2>& steps,
                      const SurfaceAccess* access, QuadOperation& q) const;
    void emit_tile_quads(Shard& shard, std::size_t tile, std::size_t first_quad, QuadBatch& batch);
    void emit_initialise_quads(Shard& shard, std::size_t tile, const std::vector<int>& surfaces,
                               QuadBatch& batch) const;
    bool initialised_in_memory(const Surface& surface) const;
    std::vector<int> surfaces_in(const std::vector<int>& surfaces, std::size_t tile) const;
    bool tile_used(std::size_t tile) const;
    void skip_initialise(const std::vector<int>& surfaces);
    void skip_resolve(std::size_t tile);
    std::uint64_t tile_pixels(std::size_t tile, int scale) const;
    void start_image();
    ByteCount worst_path(int pass, std::size_t surface) const;
    void add_initialise_traffic(std::vector<SurfaceTraffic>& traffic) const;
    void add_resolve_traffic(std::vector<SurfaceTraffic>& traffic) const;

    TraceReader& trace_;
    std::size_t tiles_across_ = static_cast<std::size_t>(tiles_across(trace_.header().width));
    FragmentSource* source_ = nullptr;
    const FramebufferOperation& operation_;
    const MachineConfig& config_;
    SurfaceMap map_;
    CostTable cost_;
    LaneTurns turns_;
    ScreenRegion region_;  // of interest, with the pixels around that its resolve reads
    OpaqueDepthTest depth_test_;
    int threads_;
    bool quads_;
    std::vector<std::uint8_t> selected_;  // by tile; empty: all
    const TileGroup* group_ = nullptr;    // run now; nullptr: the whole frame, from the trace
    std::size_t group_tile_ = 0;          // of it, read next
    std::size_t group_fragment_ = 0;
    std::vector<std::uint8_t> watched_taken_;  // by tile: the path that asks for another round was taken
    std::uint64_t watched_before_ = 0;         // and how often before this group
    int most_passes_ = 0;                      // of the groups before
    int most_geometry_passes_ = 0;
    Stage stage_ = Stage::kInitialise;
    PassSequence sequence_;
    int passes_run_ = 0;
    int geometry_passes_run_ = 0;
    FragmentCounts counts_;
    SkipCounts skipped_;
    std::vector<std::unique_ptr<Shard>> shards_;
    // Of each draw of the trace, in this pass.
    struct DrawFacts {
        std::uint32_t lane_cycles = 0;  // of its shader and of what the technique has it compute besides
        QuadOperation quad;             // what its quads have in common
        bool tested = false;            // against the opaque layer
        bool joined = false;
    };
    std::vector<DrawFacts> draws_;
    // Chunks that are not kept, and those that are, once a pass has read them all.
    std::array<std::unique_ptr<Chunk>, 2> own_chunks_;
    std::vector<std::unique_ptr<Chunk>> kept_;
    std::size_t next_kept_ = 0;
    bool keeps_ = false;
    bool kept_all_ = false;
    // By tile: the group in which its fragments run one after the other, and each partition's first.
    std::vector<std::uint32_t> bin_of_tile_;
    std::vector<std::uint32_t> first_bin_;
    std::vector<std::uint32_t> bins_;  // by fragment, and where each bin's next comes to lie: scratch
    std::vector<std::uint32_t> bin_ends_;
    Chunk* chunk_ = nullptr;  // run now
    Chunk* ahead_ = nullptr;  // the one after it
    enum class Ahead : std::uint8_t { kUnknown, kReady, kEnd };
    Ahead ahead_state_ = Ahead::kUnknown;
    FragmentChunk held_back_;     // joined fragments at its end, which those of the next chunk may join
    std::size_t chunk_next_ = 0;  // first fragment of the chunk not yet run
    std::size_t next_tile_ = 0;   // of the initialise and resolve stages
    Image image_;
    std::vector<std::uint8_t> covered_;
    // By tile, where passes have resolutions of their own: drawn to at the image's and at the lower one.
    std::vector<std::uint8_t> drawn_;
    std::vector<std::uint8_t> drawn_low_;
    int low_scale_ = 1;
    std::uint64_t scattering_ = 0;  // fragments of materials that scatter, all passes
    std::vector<std::unique_ptr<HierarchicalDepth>> depth_ranges_;  // by scale, where asked for
    DepthTests depth_tests_low_;                                    // all passes
    DepthTests depth_tests_;
    std::vector<int> initialised_;                  // surfaces that are initialised in memory
    std::vector<std::uint64_t> written_initially_;  // pixels by surface, restored ones counted each time
    std::unique_ptr<StoreMap> stores_;
    std::uint64_t resolved_pixels_ = 0;
    std::vector<std::uint64_t> pass_operated_;
};

}  // namespace ropsim
