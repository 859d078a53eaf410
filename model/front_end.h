// Shader cores and raster-order export: quads are launched, shaded in a window, and leave in raster order to
// the partition that owns their pixels.
#pragma once

#include "memory/event_wheel.h"
#include "model/front_end_counts.h"
#include "model/machine_config.h"
#include "model/partition_input.h"
#include "model/quad_operation.h"
#include "model/stage_account.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// A quad's launch and its readiness follow from the quads before it by next-free-time arithmetic; an event
// stands only where it leaves, because there it meets the partitions' back-pressure. Raster order is kept
// within a partition, which is where it can be seen; a partition that stalls holds back the others only
// through the window that its quads fill.
class FrontEnd : public WheelUnit {
 public:
    // `depth_bytes`: of one quad's depths of the opaque layer.
    FrontEnd(EventWheel& wheel, const MachineConfig& config, BatchSource& source, std::uint64_t depth_bytes);
    // Before simulation starts.
    void connect(std::vector<PartitionInput*> partitions);

    Picoseconds step(Picoseconds now) override;
    // A partition's input queue has room again.
    void partition_free(int partition);

    std::uint64_t exported() const { return exported_; }
    const FrontEndCounts& counts() const { return counts_; }
    const StageAccount& account() const { return account_; }
    StageAccount& account() { return account_; }
    // Shader-ALU busy time: lane cycles used over lane cycles there were in `total` picoseconds.
    double alu_utilisation(Picoseconds total) const;

 private:
    struct Launched {
        QuadBatch* batch;
        std::uint32_t quad;
        Picoseconds ready;  // shaded
    };
    // Quads of one partition in the window, in raster order: a ring that grows to what the scene needs.
    struct Lane {
        std::vector<Launched> ring;
        std::size_t head = 0;
        std::size_t count = 0;
        bool waiting = false;  // its head is shaded and the partition has no room

        const Launched& front() const { return ring[head]; }
        void push(const Launched& launched);
        void pop();
    };

    bool fetch();  // a quad is at next_quad_; false at the end of the frame
    void fill_window(Picoseconds now);
    Picoseconds shaded(const QuadOperation& quad, Picoseconds now);
    std::uint32_t export_quads(Picoseconds now);
    Picoseconds next_step(Picoseconds now, std::uint32_t exported);

    EventWheel& wheel_;
    const MachineConfig& config_;
    BatchSource& source_;
    int wheel_id_;
    std::vector<PartitionInput*> partitions_;
    std::vector<Lane> lanes_;
    std::size_t turn_ = 0;  // partition that exports first, in turns
    QuadBatch* batch_ = nullptr;
    std::size_t next_quad_ = 0;
    std::uint32_t in_window_ = 0;
    bool source_ended_ = false;
    bool told_end_ = false;
    std::uint64_t raster_free_ = 0;  // in 1/256 ps
    std::uint64_t lanes_free_ =
        0;  // the shader lanes as a fluid: when they have worked off what was launched
    std::uint64_t exported_ = 0;
    std::uint64_t lane_cycles_ = 0;
    std::uint64_t depth_bytes_;
    FrontEndCounts counts_;
    StageLabel label_ = StageLabel::kIdle;  // of the cycles until the next step
    StageAccount account_;
};

}  // namespace ropsim
