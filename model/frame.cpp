#include "model/frame.h"

#include "model/frame_chunk.h"
#include "model/frame_shard.h"
#include "model/interlock_cost.h"

#include <algorithm>
#include <utility>

namespace ropsim {

Frame::Frame(TraceReader& trace, const FramebufferOperation& operation, const MachineConfig& config,
             int threads, bool quads)
    : trace_(trace),
      operation_(operation),
      config_(config),
      map_(operation.declaration(), config, trace.header()),
      cost_(executed_cost(operation, config)),
      turns_(operation.declaration(), map_, config.rates),
      region_(config.skip.region.whole() ? config.skip.region
                                         : config.skip.region.grown(operation.declaration().footprint)),
      depth_test_(trace.header()),
      threads_(threads),
      quads_(quads),
      sequence_(operation.declaration()),
      written_initially_(operation.declaration().surfaces.size()),
      pass_operated_(operation.declaration().passes.size()) {
    for (std::uint32_t p = 0; p < config.partitions; ++p)
        shards_.push_back(std::make_unique<Shard>(*this, map_.pool_nodes()));
    std::vector<const PixelStore*> store_of_tile;
    for (std::size_t tile = 0; tile < trace.tile_fragments().size(); ++tile)
        store_of_tile.push_back(&shards_[static_cast<std::size_t>(map_.partition_of(tile))]->store);
    stores_ = std::make_unique<StoreMap>(trace.header().width, trace.header().height, store_of_tile);
    const auto& surfaces = operation.declaration().surfaces;
    for (std::size_t s = 0; s < surfaces.size(); ++s)
        if (initialised_in_memory(surfaces[s])) initialised_.push_back(static_cast<int>(s));
    covered_.assign(
        static_cast<std::size_t>(trace.header().width) * static_cast<std::size_t>(trace.header().height), 0);
    for (const Pass& pass : operation.declaration().passes) low_scale_ = std::max(low_scale_, pass.scale);
    if (low_scale_ > 1) {
        drawn_.assign(trace.tile_fragments().size(), 0);
        drawn_low_ = drawn_;
    }
    check_region();
    prepare_chunks();
    trace_.rewind();
    start_image();
}

Frame::~Frame() {
    if (!selected_.empty()) trace_.select_tiles({});
}

void Frame::select_tiles(std::vector<std::uint8_t> selected) {
    selected_ = std::move(selected);
    trace_.select_tiles(selected_);
    trace_.rewind();
}

bool Frame::advance(QuadBatch& batch) {
    batch.clear();
    batch.lines.resize(config_.partitions);
    batch.values.resize(config_.partitions);
    while (stage_ != Stage::kDone) {
        batch.pass = pass_number();
        if (advance_stage(batch)) return true;
        next_stage();
    }
    return false;
}

std::vector<std::string> Frame::pass_names() const {
    std::vector<std::string> names{"initialise"};
    for (const Pass& pass : operation_.declaration().passes) names.push_back(pass.name);
    names.insert(names.end(), {"resolve", "end_of_frame"});
    return names;
}

std::uint8_t Frame::pass_number() const {
    if (stage_ == Stage::kInitialise) return 0;
    const std::size_t passes = operation_.declaration().passes.size();
    return static_cast<std::uint8_t>(
        stage_ == Stage::kResolve ? passes + 1 : static_cast<std::size_t>(sequence_.pass()) + 1);
}

bool Frame::advance_stage(QuadBatch& batch) {
    switch (stage_) {
        case Stage::kInitialise:
            return advance_initialise(initialised_, batch);
        case Stage::kRestore:
            return advance_initialise(sequence_.current().restores, batch);
        case Stage::kGeometry:
            return advance_geometry(batch);
        case Stage::kImage:
            return advance_image_pass(batch);
        case Stage::kResolve:
            return advance_resolve(batch);
        case Stage::kDone:
            break;
    }
    return false;
}

void Frame::next_stage() {
    next_tile_ = 0;
    forget_chunks();
    if (group_ == nullptr) trace_.rewind();
    group_tile_ = group_fragment_ = 0;
    switch (stage_) {
        case Stage::kInitialise:
            return enter_pass();
        case Stage::kRestore:
            for (auto& shard : shards_) shard->store.restore(sequence_.current().restores, selected_);
            stage_ = sequence_.current().kind == PassKind::kImage ? Stage::kImage : Stage::kGeometry;
            return;
        case Stage::kGeometry:
        case Stage::kImage: {
            const int round = sequence_.round();
            sequence_.advance(watched_count());
            if (group_ != nullptr) leave_out_finished_tiles(round);
            return enter_pass();
        }
        case Stage::kResolve:
        case Stage::kDone:
            stage_ = Stage::kDone;
    }
}

void Frame::enter_pass() {
    if (sequence_.done() || stops_here()) {
        stage_ = stops_here() ? Stage::kDone : Stage::kResolve;
        return;
    }
    ++passes_run_;
    look_up_draws();
    const Pass& pass = sequence_.current();
    geometry_passes_run_ += pass.kind == PassKind::kGeometry ? 1 : 0;
    const bool restores = sequence_.round() > 0 && !pass.restores.empty();
    stage_ = restores ? Stage::kRestore : pass.kind == PassKind::kImage ? Stage::kImage : Stage::kGeometry;
}

// Tiles that no fragment reaches keep the opaque layer: it costs nothing.
void Frame::start_image() {
    const TraceHeader& header = trace_.header();
    image_ = Image(header.width, header.height, {"R", "G", "B"});
    for (int y = 0; y < header.height; ++y) {
        for (int x = 0; x < header.width; ++x) {
            const glm::vec3 color = shards_[0]->store.mean_background(x, y);
            float* out = image_.pixel(x, y);
            const Format format = operation_.declaration().image_format;
            for (int c = 0; c < 3; ++c) out[c] = stored_value(format, color[c]);
        }
    }
}

}  // namespace ropsim
