#include "model/shader_cores.h"

#include "base/error.h"

namespace ropsim {

ShaderCores::ShaderCores(const MachineConfig& config)
    : shader_(config.front.shader),
      rop_period_(config.rop_period_ps),
      latency_(kTimeFraction * config.shader_latency * config.shader_period_ps),
      instruction_time_(kTimeFraction * config.shader_period_ps * 4 * shader_.warp_quads * shader_.cores),
      lanes_(config.shader_alu_lanes),
      places_(shader_.cores * shader_.warps),
      cores_(shader_.cores) {}

std::uint32_t ShaderCores::next_core() const {
    CHECK(places_ > 0);
    std::uint32_t core = turn_;
    while (cores_[core].warps == shader_.warps) core = core + 1 == shader_.cores ? 0 : core + 1;
    return core;
}

std::uint32_t ShaderCores::enter() {
    const std::uint32_t core = next_core();
    turn_ = core + 1 == shader_.cores ? 0 : core + 1;
    --places_;
    if (++cores_[core].warps == shader_.warps) cores_[core].was_full = true;
    return core;
}

std::uint64_t ShaderCores::shade(std::uint32_t core, std::uint64_t entered, std::uint64_t time,
                                 std::uint32_t instructions) {
    Core& c = cores_[core];
    const std::uint64_t work = instructions * instruction_time_ / lanes_;
    c.account.charge(cycle(entered), c.was_full ? StageLabel::kSlotsFull : StageLabel::kIdle);
    c.account.charge(cycle(time), StageLabel::kFill);
    c.was_full = c.warps == shader_.warps;
    c.alu_free = std::max(c.alu_free, time) + work;
    c.account.charge(cycle(c.alu_free), StageLabel::kBusy);
    busy_ += work;
    return c.alu_free + latency_;
}

void ShaderCores::leave(std::uint32_t core) {
    --cores_[core].warps;
    ++places_;
}

StageAccount ShaderCores::finish(std::uint64_t total_cycles) {
    StageAccount all;
    for (Core& core : cores_) {
        core.account.finish(total_cycles);
        all.add(core.account);
    }
    return all;
}

double ShaderCores::utilisation(Picoseconds total) const {
    if (total == 0) return 0;
    return static_cast<double>(busy_) / static_cast<double>(kTimeFraction) /
           (static_cast<double>(total) * shader_.cores);
}

}  // namespace ropsim
