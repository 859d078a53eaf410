// The probe sees what a unit that is stepped every cycle sees, and the files say the same.
#include "model/frame_pipeline.h"
#include "model/machine_observer.h"
#include "tests/model/machine_driver.h"
#include "tests/model/vcd_reader.h"

#include <map>

namespace ropsim {
namespace {

// Looks every cycle, after all else that is due at its edge.
class EveryCycle {
 public:
    EveryCycle(EventWheel& wheel, Picoseconds period) : period_(period), id_(wheel.add(*this)) {
        wheel.arm(id_, 0);
    }
    Picoseconds step(Picoseconds now) {
        EXPECT_EQ(now, cycles_ * period_);
        ++cycles_;
        bool over = true;
        for (const RopPartition* p : partitions) over = over && p->drained();
        for (DramChannel* c : channels) {
            c->settle(now + 1);
            over = over && c->empty();
        }
        for (const auto& [name, look] : signals) values[name].push_back(look());
        return over ? kNever : now + period_;
    }
    std::uint64_t cycles() const { return cycles_; }

    std::vector<const RopPartition*> partitions;
    std::vector<DramChannel*> channels;
    std::map<std::string, std::function<std::uint64_t()>> signals;  // by the name that they have in the VCD
    std::map<std::string, std::vector<std::uint64_t>> values;       // [signal][cycle]

 private:
    Picoseconds period_;
    int id_;
    std::uint64_t cycles_ = 0;
};

// The machine of model/timed_machine.cpp, looked at twice.
class ProbedMachine : public ModelTest {
 protected:
    void simulate(const ObservationOptions& options) {
        LayeredScene scene;
        scene.width = 64;
        scene.height = 48;
        TraceReader trace(write_layers(scene));
        const auto operation = operation_for("adaptive:nodes=4", trace.header());
        Frame frame(trace, *operation, config_, 1, true);
        FramePipeline pipeline(frame, 1);
        EventWheel wheel("wheel");
        BatchWatch batches(pipeline, wheel, frame.pass_names(), config_.cache, frame.surfaces());
        FrontEnd front_end(wheel, config_, batches);
        TrafficBreakdown breakdown(frame.pass_names(), frame.draws(), tiles_across(frame.width()),
                                   tiles_across(frame.height()));
        std::vector<std::unique_ptr<RopPartition>> partitions;
        std::vector<std::unique_ptr<DramChannel>> channels;
        std::vector<PartitionInput*> connected;
        for (std::uint32_t p = 0; p < config_.partitions; ++p) {
            partitions.push_back(std::make_unique<RopPartition>(fmt::format("partition_{}", p).c_str(),
                                                                static_cast<int>(p), wheel, config_,
                                                                frame.surfaces(), batches, breakdown));
            channels.push_back(
                std::make_unique<DramChannel>(fmt::format("channel_{}", p).c_str(), wheel, config_.dram));
            partitions.back()->port.socket.bind(channels.back()->socket);
            connected.push_back(&partitions.back()->input());
        }
        front_end.connect(connected);
        EveryCycle every(wheel, config_.rop_period_ps);
        every.signals["machine.shader_window"] = [&] { return front_end.quads_in_window(); };
        MachineObserver observer(options, config_.rop_period_ps);
        observer.watch(front_end, config_);
        for (std::uint32_t p = 0; p < config_.partitions; ++p) {
            const RopPartition* const rop = partitions[p].get();
            const DramScheduler* const dram = &channels[p]->scheduler();
            const std::string scope = fmt::format("machine.partition_{}.", p);
            every.partitions.push_back(rop);
            every.channels.push_back(channels[p].get());
            every.signals[scope + "input_queue"] = [rop] { return rop->input().size(); };
            every.signals[scope + "slots"] = [rop] { return rop->slots_in_use(); };
            every.signals[scope + "miss_registers"] = [rop] { return rop->mshrs_in_use(); };
            every.signals[scope + "request_queue"] = [rop] { return rop->requests_queued(); };
            every.signals[scope + "dram_reads"] = [dram] { return dram->queued_reads(); };
            every.signals[scope + "dram_writes"] = [dram] { return dram->queued_writes(); };
            every.signals[scope + "dram_serves_writes"] = [dram] { return dram->draining() > 0 ? 1 : 0; };
            observer.watch(*partitions[p], *channels[p], p, config_);
        }
        observer.start(wheel);
        sc_core::sc_start();
        const Picoseconds end = sc_core::sc_time_stamp().value();
        cycles_ = std::max(every.cycles(), (end + config_.rop_period_ps - 1) / config_.rop_period_ps);
        for (const auto& p : partitions) cycles_ = std::max(cycles_, p->last_cycle());
        front_end.account().finish(cycles_);
        for (const auto& p : partitions) p->finish(cycles_);
        observer.finish(cycles_, batches, seen_);
        values_ = std::move(every.values);
        for (std::uint32_t p = 0; p < config_.partitions; ++p)
            for (int l = 0; l < kStageLabels; ++l)
                labels_[fmt::format("machine.partition_{}.rop_operation.{}", p,
                                    kStageLabelNames[static_cast<std::size_t>(l)])] =
                    partitions[p]->operation_account().cycles(static_cast<StageLabel>(l));
    }

    MachineConfig config_ =
        configured({"rop.partitions=2", "cache.kibibytes=2", "cache.mshrs=5", "clock.rop_mhz=900"});
    MachineObservation seen_;
    std::uint64_t cycles_ = 0;
    std::map<std::string, std::vector<std::uint64_t>> values_;
    std::map<std::string, std::uint64_t> labels_;
};

TEST_F(ProbedMachine, HistogramsAreThoseOfAUnitSteppedEveryCycle) {
    simulate({.probe_cycles = 1});
    ASSERT_GT(cycles_, 2000u);
    ASSERT_EQ(seen_.occupancy.size(), 7u);
    for (const OccupancyHistogram& h : seen_.occupancy) {
        std::map<std::uint64_t, std::uint64_t> expected;
        std::uint64_t sum = 0;
        std::uint64_t samples = 0;
        std::uint64_t most = 0;
        for (const auto& [name, values] : values_) {
            if (!name.ends_with("." + h.queue)) continue;
            for (std::uint64_t cycle = 0; cycle < cycles_; ++cycle) {
                // Behind its last step nothing changes.
                const std::uint64_t value = values[std::min<std::uint64_t>(cycle, values.size() - 1)];
                ++expected[value / h.bin_width];
                sum += value;
                ++samples;
                most = std::max(most, value);
            }
        }
        EXPECT_EQ(h.samples, samples) << h.queue;
        EXPECT_EQ(h.sum, sum) << h.queue;
        EXPECT_EQ(h.maximum, most) << h.queue;
        EXPECT_LE(most, h.capacity) << h.queue;
        EXPECT_GT(most, 0u) << h.queue;
        for (std::size_t bin = 0; bin < h.histogram.size(); ++bin)
            EXPECT_EQ(h.histogram[bin], expected[bin]) << h.queue << " " << bin;
        EXPECT_LE(h.histogram.size(), OccupancyHistogram::kBins + 1);
    }
}

TEST_F(ProbedMachine, EveryNthCycleIsSampled) {
    simulate({.probe_cycles = 7});
    for (const OccupancyHistogram& h : seen_.occupancy) {
        std::uint64_t sum = 0;
        std::uint64_t samples = 0;
        for (const auto& [name, values] : values_) {
            if (!name.ends_with("." + h.queue)) continue;
            for (std::uint64_t cycle = 0; cycle < cycles_; cycle += 7) {
                sum += values[std::min<std::uint64_t>(cycle, values.size() - 1)];
                ++samples;
            }
        }
        EXPECT_EQ(h.samples, samples) << h.queue;
        EXPECT_EQ(h.sum, sum) << h.queue;
    }
}

TEST_F(ProbedMachine, TheValueChangeDumpHasTheValuesOfItsWindow) {
    ObservationOptions options;
    options.vcd = true;
    options.vcd_from = 300;
    options.vcd_to = 1500;
    simulate(options);
    const VcdReader vcd(seen_.vcd);
    EXPECT_EQ(vcd.timescale, "1 ps");
    EXPECT_EQ(vcd.end, 1500 * config_.rop_period_ps);
    std::uint64_t changing = 0;
    for (const auto& [name, values] : values_) {
        ASSERT_TRUE(vcd.signals.contains(name)) << name;
        for (std::uint64_t cycle = 300; cycle < 1500; ++cycle) {
            ASSERT_EQ(vcd.at(name, cycle * config_.rop_period_ps), values[cycle]) << name << " " << cycle;
            changing += values[cycle] != values[cycle - 1] ? 1 : 0;
        }
    }
    EXPECT_GT(changing, 500u);
}

// One label a cycle, and over the whole run as many cycles of each as the stage has counted.
TEST_F(ProbedMachine, TheValueChangeDumpLabelsEveryCycleOnce) {
    ObservationOptions options;
    options.vcd = true;
    options.vcd_to = 1'000'000;
    simulate(options);
    const VcdReader vcd(seen_.vcd);
    std::vector<std::uint64_t> labels(cycles_);
    for (const auto& [name, counted] : labels_) {
        std::uint64_t cycles = 0;
        for (std::uint64_t cycle = 0; cycle < cycles_; ++cycle) {
            const std::uint64_t value = vcd.at(name, cycle * config_.rop_period_ps);
            cycles += value;
            labels[cycle] += value;
        }
        EXPECT_EQ(cycles, counted) << name;
    }
    for (std::uint64_t cycle = 0; cycle < cycles_; ++cycle)
        ASSERT_EQ(labels[cycle], config_.partitions) << cycle;
}

}  // namespace
}  // namespace ropsim
