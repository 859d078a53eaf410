// A whole timed frame over checked TLM sockets: the base protocol is kept, and another memory than ours will
// do.
#include "memory/dram_channel.h"
#include "model/frame_pipeline.h"
#include "model/front_end.h"
#include "model/rop_partition.h"
#include "tests/memory/base_protocol_checker.h"
#include "tests/memory/fixed_memory.h"
#include "tests/model/machine_driver.h"

#include <gmock/gmock.h>

namespace ropsim {
namespace {

// The machine of model/timed_machine.cpp with a checker in front of every memory.
class CheckedMachine : public ModelTest {
 protected:
    // `connect` makes partition p's memory and binds the checker to it.
    template <class Connect>
    void run_frame_on(const Connect& connect) {
        LayeredScene scene;
        scene.width = 96;
        scene.height = 64;
        TraceReader trace(write_layers(scene));
        const auto operation = operation_for("adaptive:nodes=4", trace.header());
        Frame frame(trace, *operation, config_, 1, true);
        FramePipeline pipeline(frame, 1);
        FrontEnd front_end(wheel_, config_, pipeline);
        TrafficBreakdown breakdown(frame.pass_names(), frame.draws(), tiles_across(frame.width()),
                                   tiles_across(frame.height()));
        std::vector<std::unique_ptr<RopPartition>> partitions;
        std::vector<std::unique_ptr<BaseProtocolChecker>> checkers;
        std::vector<PartitionInput*> connected;
        for (std::uint32_t p = 0; p < config_.partitions; ++p) {
            partitions.push_back(std::make_unique<RopPartition>(fmt::format("partition_{}", p).c_str(),
                                                                static_cast<int>(p), wheel_, config_,
                                                                frame.surfaces(), pipeline, breakdown));
            checkers.push_back(std::make_unique<BaseProtocolChecker>(fmt::format("checker_{}", p).c_str()));
            partitions.back()->port.socket.bind(checkers.back()->target);
            connect(p, *checkers.back());
            connected.push_back(&partitions.back()->input());
        }
        front_end.connect(connected);
        sc_core::sc_start();
        std::uint64_t quads = 0;
        for (std::size_t p = 0; p < partitions.size(); ++p) {
            checkers[p]->finish();
            EXPECT_THAT(checkers[p]->violations(), testing::IsEmpty()) << p;
            EXPECT_GT(checkers[p]->transactions(), 100u);
            transactions_ += checkers[p]->transactions();
            quads += partitions[p]->quads();
            for (const auto& surface : partitions[p]->miss_port())
                for (const MissPortBytes& bytes : surface) miss_port_bytes_ += bytes.read + bytes.write;
        }
        EXPECT_GT(quads, 1000u);
        EXPECT_EQ(quads, front_end.exported());
    }

    MachineConfig config_ = configured({"rop.partitions=4"});
    int resolution_ = (use_picosecond_resolution(), 0);
    EventWheel wheel_{"wheel"};
    std::uint64_t transactions_ = 0;
    std::uint64_t miss_port_bytes_ = 0;
};

TEST_F(CheckedMachine, KeepsTheProtocolWithOurChannels) {
    std::vector<std::unique_ptr<DramChannel>> channels;
    run_frame_on([&](std::uint32_t p, BaseProtocolChecker& checker) {
        channels.push_back(
            std::make_unique<DramChannel>(fmt::format("channel_{}", p).c_str(), wheel_, config_.dram));
        checker.initiator.bind(channels.back()->socket);
    });
    DramStatistics total;
    for (const auto& channel : channels) {
        EXPECT_TRUE(channel->empty());
        channel->finish(sc_core::sc_time_stamp().value());
        total.add(channel->statistics());
    }
    EXPECT_EQ(total.reads + total.writes, transactions_);
    EXPECT_EQ(total.total_read().useful + total.total_write().useful, miss_port_bytes_);
}

TEST_F(CheckedMachine, RunsOnAnotherMemory) {
    std::vector<std::unique_ptr<FixedMemory>> memories;
    run_frame_on([&](std::uint32_t p, BaseProtocolChecker& checker) {
        memories.push_back(std::make_unique<FixedMemory>(fmt::format("memory_{}", p).c_str(),
                                                         sc_core::sc_time(150, sc_core::SC_NS),
                                                         sc_core::sc_time(40, sc_core::SC_PS), 16));
        checker.initiator.bind(memories.back()->socket);
    });
    // What crosses the miss ports does not depend on the memory, only when it does.
    EXPECT_GT(miss_port_bytes_, 0u);
    EXPECT_GT(sc_core::sc_time_stamp().value(), miss_port_bytes_ / config_.partitions * 40);
}

}  // namespace
}  // namespace ropsim
