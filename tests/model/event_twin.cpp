// The twin's front end, and the loop that ticks everything once a cycle.
#include "tests/model/event_twin.h"

#include "base/error.h"
#include "model/front_end_counts.h"
#include "tests/model/twin_partition.h"
#include "tests/model/twin_slice.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <vector>

namespace ropsim {

namespace {

// Shader cores: a window of quads; raster and ALUs work them off one after the other; each leaves for its
// partition in raster order of that partition.
class TwinFrontEnd {
 public:
    TwinFrontEnd(const MachineConfig& config, Frame& frame)
        : config_(config), frame_(frame), lanes_(config.partitions) {}

    void tick(std::uint64_t cycle, std::vector<std::unique_ptr<TwinPartition>>& partitions) {
        const Picoseconds now = cycle * config_.rop_period_ps;
        while (window_ < config_.shader_quads_in_flight && fetch()) launch(now);
        std::uint32_t exported = 0;
        for (std::uint32_t i = 0; i < config_.partitions && exported < config_.export_quads_per_cycle; ++i) {
            const std::uint32_t p = (turn_ + i) % config_.partitions;
            if (lanes_[p].empty() || lanes_[p].front().ready > now || !partitions[p]->has_room()) continue;
            partitions[p]->push(lanes_[p].front().batch, lanes_[p].front().quad, cycle);
            lanes_[p].pop_front();
            ++exported;
        }
        window_ -= exported;
        // Whoever had the first turn in a cycle that exported goes last in the next.
        if (exported > 0) {
            turn_ = (turn_ + 1) % config_.partitions;
            end_ = cycle + 1;
        }
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

 private:
    struct Shading {
        QuadBatch* batch;
        std::uint32_t quad;
        Picoseconds ready;
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
    void launch(Picoseconds now) {
        const QuadOperation& q = current_->quads[next_++];
        Picoseconds ready = now;
        if (q.kind == QuadKind::kDraw || q.kind == QuadKind::kCulled) {
            const auto period = static_cast<long double>(config_.shader_period_ps);
            rastered_ = std::max<long double>(rastered_, static_cast<long double>(now)) +
                        period / config_.raster_quads_per_cycle;
            ready = static_cast<Picoseconds>(rastered_);
            if (q.kind == QuadKind::kDraw) {
                shaded_ =
                    std::max(shaded_, rastered_) + period * q.shader_lane_cycles / config_.shader_alu_lanes;
                ready = static_cast<Picoseconds>(shaded_) + config_.shader_latency * config_.shader_period_ps;
            }
        }
        if (!reaches_partition(q)) return quad_done(current_);
        lanes_[q.partition].push_back({current_, static_cast<std::uint32_t>(next_ - 1), ready});
        ++window_;
    }

    const MachineConfig& config_;
    Frame& frame_;
    std::vector<std::deque<Shading>> lanes_;  // by partition
    std::vector<std::unique_ptr<QuadBatch>> batches_;
    QuadBatch* current_ = nullptr;
    std::size_t next_ = 0;
    bool ended_ = false;
    std::uint32_t window_ = 0;
    std::uint32_t turn_ = 0;
    long double rastered_ = 0;
    long double shaded_ = 0;
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
        return done ? kNever : following;
    }
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

 private:
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
    return result;
}

}  // namespace ropsim
