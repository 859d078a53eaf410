// Shader cores and raster-order export: quads are launched, shaded out of order in a window, and leave in raster order
// to the partition that owns their pixels.
#pragma once

#include <cstdint>
#include <vector>

#include "memory/event_wheel.h"
#include "model/machine_config.h"
#include "model/quad_operation.h"
#include "model/rop_partition.h"
#include "model/stage_account.h"

namespace ropsim {

// Reservation timestamps: a quad's launch and its readiness follow from the quads before it by next-free-time
// arithmetic; an event stands only where it leaves, because there it meets the partitions' back-pressure. The window
// carries that pressure back to the launch: a quad is launched once there is room for it.
class FrontEnd : public WheelUnit {
   public:
    FrontEnd(EventWheel& wheel, const MachineConfig& config, BatchSource& source);
    // Before simulation starts.
    void connect(std::vector<RopPartition*> partitions) { partitions_ = std::move(partitions); }
    int wheel_id() const { return wheel_id_; }

    Picoseconds step(Picoseconds now) override;
    // A partition that had no room for the next quad has some.
    void partition_free(int partition);

    bool finished() const { return finished_; }
    std::uint64_t exported() const { return exported_; }
    const StageAccount& account() const { return account_; }
    StageAccount& account() { return account_; }
    // Shader-ALU busy time: lane cycles used over lane cycles there were, for `total` picoseconds.
    double alu_utilisation(Picoseconds total) const;

   private:
    bool fetch();  // the next quad becomes current_; false at the end of the frame
    void launch();
    const QuadOperation& quad() const { return batch_->quads[next_quad_]; }

    EventWheel& wheel_;
    const MachineConfig& config_;
    BatchSource& source_;
    int wheel_id_;
    std::vector<RopPartition*> partitions_;
    QuadBatch* batch_ = nullptr;
    std::size_t next_quad_ = 0;
    bool launched_ = false;  // ready_ is that of the current quad
    bool finished_ = false;
    Picoseconds ready_ = 0;
    std::uint64_t raster_free_ = 0;  // in 1/256 ps
    // Shader lanes as a fluid: time at which the lanes have worked off what was launched, in 1/256 ps.
    std::uint64_t lanes_free_ = 0;
    std::vector<Picoseconds> exported_at_;  // ring of the window: when quad i left
    std::uint64_t exported_ = 0;
    std::uint64_t export_cycle_ = 0;      // cycle being filled
    std::uint32_t exported_in_cycle_ = 0;
    std::uint64_t lane_cycles_ = 0;
    int waiting_for_ = -1;
    StageLabel waiting_label_ = StageLabel::kIdle;
    StageAccount account_;
};

}  // namespace ropsim
