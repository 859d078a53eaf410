// The twin's front end, and the loop that ticks everything once a cycle.
#include "tests/model/event_twin.h"

#include "base/error.h"
#include "model/front_end_counts.h"
#include "model/texture_lines.h"
#include "tests/model/twin_partition.h"
#include "tests/model/twin_reads.h"
#include "tests/model/twin_slice.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

namespace ropsim {

namespace {

// A window of quads, warps of them in cores, and each quad leaving for its partition in raster order of that
// partition. Times between ticks are real numbers of picoseconds.
class TwinFrontEnd {
 public:
    using Time = long double;

    TwinFrontEnd(const MachineConfig& config, Frame& frame)
        : config_(config),
          front_(config.front),
          frame_(frame),
          lanes_(config.partitions),
          cores_(config.front.shader.cores),
          fetching_(config.front.shader.cores) {}

    void tick(std::uint64_t cycle, std::vector<std::unique_ptr<TwinPartition>>& partitions) {
        const Picoseconds now = cycle * config_.rop_period_ps;
        settle_depths(now);
        while (window_ < config_.shader_quads_in_flight && fetch()) take_in(now);
        if (!open_.empty() && ended_ && order_.empty()) close_warp(last_packed_);
        if (!open_.empty() && deadline_ <= static_cast<Time>(now)) close_warp(deadline_);
        for (std::size_t c = 0; c < texture_caches.size(); ++c)
            for (; texture_caches[c]->answered(now); texture_caches[c]->take()) {
                shade(*fetching_[c].front(), now);
                fetching_[c].pop_front();
            }
        while (!closed_.empty() && enter_core(*closed_.front())) {
            Warp& warp = *closed_.front();
            const Picoseconds entered = std::max(now, static_cast<Picoseconds>(warp.closed));
            if (warp.texels.empty()) {
                shade(warp, now);
            } else {
                texture_caches[warp.core]->push(warp.texels, entered);
                fetching_[warp.core].push_back(closed_.front());
            }
            closed_.pop_front();
        }
        export_quads(cycle, partitions);
        if (!ended_ || window_ > 0) return;
        const auto rastered = static_cast<Picoseconds>(rastered_);
        end_ = std::max(end_, (rastered + config_.rop_period_ps - 1) / config_.rop_period_ps);
        if (rastered > now) return;
        for (auto& p : partitions) p->upstream_finished();
    }
    void quad_done(QuadBatch* batch) {
        if (--batch->unfinished > 0) return;
        std::erase_if(batches_, [&](const std::unique_ptr<QuadBatch>& b) {
            return b.get() == batch && b.get() != current_;
        });
    }
    std::uint64_t end() const { return end_; }

    std::vector<std::unique_ptr<TwinReadCache>> depth_units;     // by partition, where there are any
    std::vector<std::unique_ptr<TwinReadCache>> texture_caches;  // by core

 private:
    struct Warp {
        std::uint32_t quads = 0;  // then those that have not left
        std::uint32_t instructions = 0;
        Time closed = 0;
        std::size_t core = 0;
        std::optional<Picoseconds> ready;
        std::vector<LineRead> texels;
        bool empty() const { return quads == 0; }
    };
    struct Core {
        std::uint32_t warps = 0;
        Time alu_free = 0;
    };
    struct Rastered {
        QuadBatch* batch;
        std::uint32_t quad;
        Time time;
    };
    struct Shading {
        QuadBatch* batch;
        std::uint32_t quad;
        std::shared_ptr<Warp> warp;  // none: it is not shaded
    };
    bool fetch() {
        while (!ended_ && (current_ == nullptr || next_ == current_->quads.size())) {
            batches_.push_back(std::make_unique<QuadBatch>());
            current_ = batches_.back().get();
            ended_ = !frame_.advance(*current_);
            current_->unfinished = current_->quads.size();
            next_ = 0;
        }
        return !ended_;
    }
    void take_in(Picoseconds now) {
        const auto number = static_cast<std::uint32_t>(next_);
        const QuadOperation& q = current_->quads[next_++];
        Time time = static_cast<Time>(now);
        if (q.kind == QuadKind::kDraw || q.kind == QuadKind::kCulled) {
            const auto period = static_cast<Time>(config_.shader_period_ps);
            rastered_ = std::max(rastered_, time) + period / config_.raster_quads_per_cycle;
            if (q.new_tile) {
                tiled_ = std::max(tiled_, time) + period / front_.raster_tiles_per_cycle;
                rastered_ = std::max(rastered_, tiled_);
            }
            time = rastered_;
        }
        if (!reaches_partition(q) && q.depth_lines == 0) return quad_done(current_);
        ++window_;
        if (q.depth_lines != 0) {
            std::vector<LineRead> lines;
            for (std::uint32_t l = q.first_line - q.depth_lines; l < q.first_line; ++l) {
                const LineAccess& a = current_->lines[q.partition][l];
                lines.push_back({a.line_address, a.read_sectors, a.surface});
            }
            depth_units[q.partition]->push(lines, static_cast<Picoseconds>(time));
        }
        order_.push_back({current_, number, time});
        if (q.depth_lines == 0) settle_depths(now);
    }
    // In raster order, up to the first whose depth is not known.
    void settle_depths(Picoseconds now) {
        for (; !order_.empty(); order_.pop_front()) {
            const Rastered first = order_.front();
            const QuadOperation& q = first.batch->quads[first.quad];
            Time time = first.time;
            if (q.depth_lines != 0) {
                if (!depth_units[q.partition]->answered(now)) return;
                depth_units[q.partition]->take();
                time = std::max(time, static_cast<Time>(now));
            }
            if (reaches_partition(q)) {
                pack(first, q, time);
                continue;
            }
            --window_;
            end_ = std::max<std::uint64_t>(end_, now / config_.rop_period_ps);
            quad_done(first.batch);
        }
    }
    void pack(const Rastered& rastered, const QuadOperation& q, Time time) {
        QuadBatch* batch = rastered.batch;
        const std::uint32_t number = rastered.quad;
        if (q.kind != QuadKind::kDraw && q.kind != QuadKind::kCulled) {
            if (!open_.empty()) close_warp(last_packed_);
            lanes_[q.partition].push_back({batch, number, nullptr});
            return;
        }
        last_packed_ = std::max(last_packed_, time);
        if (!open_.empty() && (open_draw_ != q.draw || open_pass_ != batch->pass)) close_warp(last_packed_);
        if (!open_.empty() && last_packed_ > deadline_) close_warp(deadline_);
        if (open_.empty()) {
            deadline_ =
                last_packed_ + static_cast<Time>(front_.shader.pack_timeout * config_.shader_period_ps);
            filling_ = std::make_shared<Warp>();
        }
        open_draw_ = q.draw;
        open_pass_ = batch->pass;
        for_texture_lines(config_, frame_.surfaces().textures(), q,
                          [&](const LineRead& read) { open_.texels.push_back(read); });
        open_.quads += 1;
        open_.instructions = std::max(open_.instructions, (q.shader_lane_cycles + 3) / 4);
        lanes_[q.partition].push_back({batch, number, filling_});
        if (open_.quads == front_.shader.warp_quads) close_warp(last_packed_);
    }
    void close_warp(Time time) {
        *filling_ = open_;
        filling_->closed = time;
        closed_.push_back(filling_);
        open_ = {};
    }
    // The next core in turn that has a place.
    bool enter_core(Warp& warp) {
        for (std::size_t i = 0; i < cores_.size(); ++i) {
            const std::size_t c = (core_turn_ + i) % cores_.size();
            if (cores_[c].warps == front_.shader.warps) continue;
            ++cores_[c].warps;
            warp.core = c;
            core_turn_ = (c + 1) % cores_.size();
            return true;
        }
        return false;
    }
    void shade(Warp& warp, Picoseconds now) {
        Core& core = cores_[warp.core];
        const auto period = static_cast<Time>(config_.shader_period_ps);
        const Time lanes = static_cast<Time>(config_.shader_alu_lanes) / front_.shader.cores;
        core.alu_free = std::max({core.alu_free, warp.closed, static_cast<Time>(now)}) +
                        period * warp.instructions * 4 * front_.shader.warp_quads / lanes;
        warp.ready = static_cast<Picoseconds>(core.alu_free + config_.shader_latency * period);
    }
    void export_quads(std::uint64_t cycle, std::vector<std::unique_ptr<TwinPartition>>& partitions) {
        const Picoseconds now = cycle * config_.rop_period_ps;
        std::uint32_t exported = 0;
        for (std::uint32_t i = 0; i < config_.partitions && exported < config_.export_quads_per_cycle; ++i) {
            const std::uint32_t p = (turn_ + i) % config_.partitions;
            if (lanes_[p].empty() || !partitions[p]->has_room()) continue;
            Shading& first = lanes_[p].front();
            if (first.warp && (!first.warp->ready || *first.warp->ready > now)) continue;
            partitions[p]->push(first.batch, first.quad, cycle);
            if (first.warp && --first.warp->quads == 0) --cores_[first.warp->core].warps;
            lanes_[p].pop_front();
            ++exported;
        }
        window_ -= exported;
        // Whoever had the first turn in a cycle that exported goes last in the next.
        if (exported > 0) {
            turn_ = (turn_ + 1) % config_.partitions;
            end_ = cycle + 1;
        }
    }

    const MachineConfig& config_;
    const FrontEndConfig& front_;
    Frame& frame_;
    std::vector<std::deque<Shading>> lanes_;  // by partition
    std::vector<Core> cores_;
    std::size_t core_turn_ = 0;
    std::vector<std::unique_ptr<QuadBatch>> batches_;
    QuadBatch* current_ = nullptr;
    std::size_t next_ = 0;
    bool ended_ = false;
    std::uint32_t window_ = 0;
    std::uint32_t turn_ = 0;
    Time rastered_ = 0;
    Time tiled_ = 0;
    Time last_packed_ = 0;
    Time deadline_ = 0;
    Warp open_;  // being filled
    std::uint16_t open_draw_ = 0;
    std::uint8_t open_pass_ = 0;
    std::shared_ptr<Warp> filling_;  // what it will be
    std::deque<std::shared_ptr<Warp>> closed_;
    std::deque<Rastered> order_;
    std::vector<std::deque<std::shared_ptr<Warp>>> fetching_;  // by core
    std::uint64_t end_ = 0;
};

class TwinMachine : public sc_core::sc_module, public WheelUnit {
 public:
    TwinMachine(const sc_core::sc_module_name& name, Frame& frame, const MachineConfig& config)
        : sc_core::sc_module(name), wheel("wheel"), config_(config), front_end_(config, frame) {
        id_ = wheel.add(*this);
        for (std::uint32_t p = 0; p < config.partitions; ++p) {
            woken_.push_back(false);
            const auto wake = [this, p] {
                woken_[p] = true;
                wheel.arm(id_, wheel.now());
            };
            partitions.push_back(
                std::make_unique<TwinPartition>(fmt::format("port_{}", p), wheel, config, frame.surfaces(),
                                                wake, [this](QuadBatch* b) { front_end_.quad_done(b); }));
            channels.push_back(
                std::make_unique<DramChannel>(fmt::format("channel_{}", p).c_str(), wheel, config.dram));
            if (config.l2.present()) {
                slices.push_back(std::make_unique<TwinSlice>(fmt::format("slice_{}", p).c_str(), wheel,
                                                             config.l2, config.rop_period_ps,
                                                             [this] { wheel.arm(id_, wheel.now()); }));
                partitions.back()->port.socket.bind(slices.back()->socket);
                slices.back()->port.socket.bind(channels.back()->socket);
            } else {
                partitions.back()->port.socket.bind(channels.back()->socket);
            }
        }
        make_read_caches(frame);
        wheel.arm(id_, 0);
    }

    Picoseconds step(Picoseconds now) override {
        const std::uint64_t cycle = now / config_.rop_period_ps;
        const Picoseconds following = (cycle + 1) * config_.rop_period_ps;
        if (now % config_.rop_period_ps != 0) return following;
        // Memory that speaks at the very edge of a cycle is heard in it, by the partition it spoke to.
        const bool again = cycle < next_cycle_;
        if (!again) front_end_.tick(cycle, partitions);
        next_cycle_ = cycle + 1;
        bool done = true;
        for (std::size_t p = 0; p < partitions.size(); ++p) {
            if (!again || woken_[p]) partitions[p]->tick(cycle);
            woken_[p] = false;
            done = done && partitions[p]->drained();
            if (slices.empty()) continue;
            slices[p]->tick(cycle, partitions[p]->drained());
            done = done && slices[p]->drained();
        }
        for (auto& cache : front_end_.depth_units) cache->tick(cycle);
        for (auto& cache : front_end_.texture_caches) cache->tick(cycle);
        for (auto& port : read_ports) {
            port->tick(cycle);
            done = done && port->drained();
        }
        return done ? kNever : following;
    }
    const TwinFrontEnd& front_end() const { return front_end_; }
    std::uint64_t cycles() const {
        std::uint64_t end =
            std::max(front_end_.end(), (dram_end() + config_.rop_period_ps - 1) / config_.rop_period_ps);
        for (const auto& p : partitions) end = std::max(end, p->end());
        for (const auto& s : slices) end = std::max(end, s->end());
        return end;
    }
    // The last data on any channel's pins.
    Picoseconds dram_end() const { return last_data_; }
    void note_last_data(Picoseconds time) { last_data_ = std::max(last_data_, time); }

    EventWheel wheel;
    std::vector<std::unique_ptr<TwinPartition>> partitions;
    std::vector<std::unique_ptr<TwinSlice>> slices;  // none, or one a partition
    std::vector<std::unique_ptr<DramChannel>> channels;
    std::vector<std::unique_ptr<TwinReadPort>> read_ports;  // none, or one a partition

 private:
    // Without slices: a twin slice has one socket for one initiator.
    void make_read_caches(const Frame& frame) {
        const bool depths = has_depth_units(config_, frame.has_opaque_layer());
        const int textures = frame.surfaces().textures();
        if (!depths && textures < 0) return;
        CHECK(slices.empty());
        for (std::uint32_t p = 0; p < config_.partitions; ++p) {
            read_ports.push_back(std::make_unique<TwinReadPort>(fmt::format("read_port_{}", p), wheel,
                                                                frame.surfaces().surfaces(),
                                                                [this] { wheel.arm(id_, wheel.now()); }));
            read_ports.back()->port.socket.bind(channels[p]->socket);
        }
        for (std::uint32_t p = 0; depths && p < config_.partitions; ++p)
            front_end_.depth_units.push_back(std::make_unique<TwinReadCache>(
                wheel, depth_unit_config(config_), config_.rop_period_ps,
                [this, p](std::uint64_t address) { return std::pair(read_ports[p].get(), address); }));
        const std::uint64_t base = textures < 0 ? 0 : frame.surfaces().first_address(textures);
        const auto locate = [this, base](std::uint64_t address) {
            const std::uint64_t piece = address / 256;
            return std::pair(read_ports[piece % read_ports.size()].get(),
                             base + piece / read_ports.size() * 256 + address % 256);
        };
        for (std::uint32_t c = 0; textures >= 0 && c < config_.front.shader.cores; ++c)
            front_end_.texture_caches.push_back(std::make_unique<TwinReadCache>(
                wheel, texture_cache_config(config_), config_.rop_period_ps, locate));
    }

    const MachineConfig& config_;
    TwinFrontEnd front_end_;
    int id_;
    std::uint64_t next_cycle_ = 0;
    std::vector<bool> woken_;  // by partition: memory has spoken since its last tick
    Picoseconds last_data_ = 0;
};

// When data last moved on a channel: column commands tell, as they are issued.
class LastData : public DramCommandTrace {
 public:
    LastData(TwinMachine& machine, const DramConfig& dram) : machine_(machine), dram_(dram) {}
    void command(DramCycle cycle, DramCommand command, std::uint32_t, std::uint32_t, std::uint32_t) override {
        if (command == DramCommand::kRead)
            machine_.note_last_data((cycle + dram_.read_cycles()) * dram_.tck_ps);
        if (command == DramCommand::kWrite)
            machine_.note_last_data((cycle + dram_.write_cycles()) * dram_.tck_ps);
    }

 private:
    TwinMachine& machine_;
    const DramConfig& dram_;
};

}  // namespace

MachineResult run_event_twin(Frame& frame, const MachineConfig& config) {
    use_picosecond_resolution();
    TwinMachine machine("twin", frame, config);
    LastData last_data(machine, config.dram);
    for (auto& channel : machine.channels) channel->set_trace(&last_data);
    sc_core::sc_start();
    MachineResult result;
    result.timed = true;
    result.rop_cycles = machine.cycles();
    result.miss_port.resize(static_cast<std::size_t>(frame.surfaces().surfaces()));
    for (const auto& s : machine.slices) {
        CHECK(s->drained(), "the twin stopped early");
        if (!result.l2) result.l2.emplace();
        result.l2->cache.add(s->cache_statistics());
        result.l2->memory[0][0].read += s->memory_bytes();
    }
    for (const auto& p : machine.partitions) {
        CHECK(p->drained(), "the twin stopped early");
        result.cache.add(p->cache_statistics());
        for (std::size_t s = 0; s < result.miss_port.size(); ++s)
            for (std::size_t c = 0; c < kMemoryCauses; ++c) {
                result.miss_port[s][c].read += p->miss_port()[s][c].read;
                result.miss_port[s][c].write += p->miss_port()[s][c].write;
            }
    }
    for (const auto& port : machine.read_ports)
        for (std::size_t s = 0; s < result.miss_port.size(); ++s)
            for (std::size_t c = 0; c < kMemoryCauses; ++c)
                result.miss_port[s][c].read += port->bytes()[s][c].read;
    for (const auto& unit : machine.front_end().depth_units)
        result.front_end.depth_cache.add(unit->statistics());
    for (const auto& cache : machine.front_end().texture_caches)
        result.front_end.texture_cache.add(cache->statistics());
    return result;
}

}  // namespace ropsim
