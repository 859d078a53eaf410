#include "model/tile_sample_machine.h"

#include "base/error.h"
#include "memory/dram_channel.h"
#include "memory/event_wheel.h"
#include "memory/l2_slice.h"
#include "memory/simulate.h"
#include "model/front_end.h"
#include "model/front_end_caches.h"
#include "model/rop_partition.h"

#include <algorithm>
#include <utility>

namespace ropsim {

namespace {

// Stands where a partition is that no quad goes to.
class NoPartition {
 public:
    NoPartition(EventWheel& wheel, const MachineConfig& config)
        : id_(wheel.add(*this)), input_(wheel, id_, 0, config) {}
    PartitionInput& input() { return input_; }
    Picoseconds step(Picoseconds) { return kNever; }

 private:
    int id_;
    PartitionInput input_;
};

// A sampled partition and what stands before and behind it.
class PartitionColumn : public sc_core::sc_module, public BatchSource {
 public:
    PartitionColumn(const sc_core::sc_module_name& name, EventWheel& wheel, const MachineConfig& config,
                    const Frame& frame, SampleFeeder& feeder, SampleStream& stream, const SamplePlan& plan)
        : sc_core::sc_module(name),
          wheel_(wheel),
          period_(config.rop_period_ps),
          feeder_(feeder),
          stream_(stream),
          whole_(plan.whole()),
          share_(share_of(config)),
          front_end(wheel, share_, *this),
          nobody_(wheel, config),
          breakdown_(frame.pass_names(), frame.draws(), tiles_across(frame.width()),
                     tiles_across(frame.height())),
          partition("partition", stream.partition(), wheel, config, frame.surfaces(), *this, breakdown_,
                    compressed_surfaces(config, frame.surfaces(), frame.operation().declaration(),
                                        frame.initial_pixels(), stream.partition())),
          channel("channel", wheel, config.dram) {
        if (config.l2.present()) {
            slice = std::make_unique<L2Slice>("l2", wheel, config.l2, config.rop_period_ps);
            partition.port.socket.bind(slice->socket);
            partition.connect(*slice);
            slice->port.bind(channel);
        } else {
            partition.port.bind(channel);
        }
        std::vector<PartitionInput*> inputs(config.partitions, &nobody_.input());
        inputs[static_cast<std::size_t>(stream.partition())] = &partition.input();
        front_end.connect(inputs);
        std::vector<CompressedSurfaces*> compressed(config.partitions, partition.compressed());
        caches = std::make_unique<FrontEndCaches>(wheel, share_, frame.surfaces(), frame.has_opaque_layer(),
                                                  compressed, breakdown_, front_end);
        for (const auto& read_port : caches->ports) {
            if (slice)
                read_port->port.socket.bind(slice->socket);
            else
                read_port->port.bind(channel);
        }
    }

    QuadBatch* next() override {
        SampleBatch* batch = stream_.next();
        while (batch == nullptr && feeder_.advance()) batch = stream_.next();
        return batch != nullptr ? batch : stream_.next();
    }

    void release(QuadBatch* of) override {
        auto* batch = static_cast<SampleBatch*>(of);
        if (batch->last && !whole_) part_written(batch->part);
        stream_.release(batch);
    }

    // Before simulation starts, and as soon as nothing of a stretch is left in the partition.
    void prepare_stretch() {
        if (whole_) return;
        while (stream_.stretches().size() <= stretch_ && feeder_.advance()) {
        }
        if (stretch_ < stream_.stretches().size() && stream_.stretches()[stretch_].cache.has_value())
            partition.replace_cache(stream_.take_cache(stretch_));
    }

    void finish(std::uint64_t cycles, SampledTiming& timing) {
        partition.finish(cycles);
        if (slice) slice->finish(cycles);
        channel.finish(cycles * period_);
        if (whole_) {
            timed_ = {now()};
            timed_[0].cycles = partition.last_cycle();
        }
        timed_.resize(stream_.stretches().size());
        timing.stretches.push_back(timed_);
        timing.dram.add(channel.statistics());
    }

    std::uint64_t last_cycle() const {
        std::uint64_t last = std::max(front_end.account().labelled(), partition.last_cycle());
        return slice ? std::max(last, slice->last_cycle()) : last;
    }

 private:
    TimedStretch now() const {
        TimedStretch all{wheel_.now() / period_, {}, {}};
        const std::array<const StageAccount*, 2> accounts{&partition.tag_account(),
                                                          &partition.operation_account()};
        for (std::size_t a = 0; a < accounts.size(); ++a)
            for (std::size_t l = 0; l < all.labels[a].size(); ++l)
                all.labels[a][l] = accounts[a]->cycles(static_cast<StageLabel>(l));
        const DramStatistics& d = channel.statistics();
        all.rows = {d.row_hits, d.row_misses, d.row_conflicts};
        return all;
    }

    void part_written(SampleBatch::Part part) {
        if (part == SampleBatch::Part::kWarm) {
            before_ = now();
        } else if (part == SampleBatch::Part::kMeasured) {
            TimedStretch t = now();
            t.cycles -= before_.cycles;
            for (std::size_t a = 0; a < t.labels.size(); ++a)
                for (std::size_t l = 0; l < t.labels[a].size(); ++l) t.labels[a][l] -= before_.labels[a][l];
            for (std::size_t r = 0; r < t.rows.size(); ++r) t.rows[r] -= before_.rows[r];
            timed_.push_back(t);
        } else if (part == SampleBatch::Part::kTail) {
            ++stretch_;
            prepare_stretch();
        }
    }

    EventWheel& wheel_;
    Picoseconds period_;
    SampleFeeder& feeder_;
    SampleStream& stream_;
    bool whole_;
    MachineConfig share_;

 public:
    FrontEnd front_end;

 private:
    NoPartition nobody_;
    TrafficBreakdown breakdown_;

 public:
    RopPartition partition;
    DramChannel channel;
    std::unique_ptr<L2Slice> slice;
    std::unique_ptr<FrontEndCaches> caches;  // their ports all lead here

 private:
    std::size_t stretch_ = 0;  // the one in the partition, or the next
    TimedStretch before_;
    std::vector<TimedStretch> timed_;
};

}  // namespace

SampledTiming run_sample_machine(const Frame& frame, const MachineConfig& config, const SamplePlan& plan,
                                 SampleFeeder& feeder,
                                 const std::vector<std::unique_ptr<SampleStream>>& streams) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    std::vector<std::unique_ptr<PartitionColumn>> columns;
    for (const auto& stream : streams)
        columns.push_back(
            std::make_unique<PartitionColumn>(fmt::format("column_{}", stream->partition()).c_str(), wheel,
                                              config, frame, feeder, *stream, plan));
    for (const auto& column : columns) column->prepare_stretch();
    simulate();
    std::uint64_t last = (wheel.now() + config.rop_period_ps - 1) / config.rop_period_ps;
    for (const auto& column : columns) last = std::max(last, column->last_cycle());
    SampledTiming timing;
    for (const auto& column : columns) column->finish(last, timing);
    return timing;
}

}  // namespace ropsim
