#include "model/interlock_cost.h"

#include "base/error.h"

#include <algorithm>

namespace ropsim {

MachineConfig interlock_machine(const MachineConfig& config) {
    MachineConfig machine = config;
    machine.interlock.executes = true;
    machine.lanes = 4;
    machine.fast_clear = false;
    machine.compression = {};
    machine.crossbar_latency = 0;
    // A lane executes instructions, whatever the format.
    machine.rates = {1, 1, 1, 64};
    if (machine.l2.present()) return machine;
    L2Config& l2 = machine.l2;
    l2.cache = config.cache;
    l2.cache.section_bytes = {};
    const std::uint32_t sectors = l2.cache.line_bytes / l2.cache.sector_bytes;
    l2.request_queue = std::max(l2.request_queue, sectors + 1);
    try {
        check_cache_config(l2.cache);
    } catch (const UserError& error) {
        throw UserError("--engine shader", fmt::format("cache.* as a share of the L2: {}", error.what()));
    }
    return machine;
}

namespace {

int instructions_of(const Work& work, const InterlockConfig& config) {
    std::uint32_t sum = 0;
    for (std::size_t u = 0; u < work.units.size(); ++u) sum += work.units[u] * config.instructions[u];
    return static_cast<int>(sum);
}

int rop_cycles(int shader_cycles, const MachineConfig& config) {
    const std::uint64_t ps = static_cast<std::uint64_t>(shader_cycles) * config.shader_period_ps;
    return static_cast<int>((ps + config.rop_period_ps - 1) / config.rop_period_ps);
}

}  // namespace

CostTable executed_cost(const FramebufferOperation& operation, const MachineConfig& config) {
    if (!config.interlock.executes) return operation.cost(config.datapath);
    const InterlockConfig& interlock = config.interlock;
    DatapathShape shape;
    for (std::size_t u = 0; u < shape.latency.size(); ++u)
        shape.latency[u] = static_cast<int>(interlock.instructions[u] * interlock.instruction_latency);
    // A load that depends on a load.
    const std::uint64_t load_ps = (interlock.memory_latency + config.l2.latency) * config.rop_period_ps;
    shape.latency[static_cast<std::size_t>(Unit::kFetchStage)] =
        static_cast<int>(load_ps / config.shader_period_ps);
    CostTable table = operation.cost(shape);
    for (PathCost& path : table) {
        path.interval = instructions_of(path.work, interlock);
        path.work.latency = rop_cycles(std::max(path.work.latency, path.interval), config);
        for (std::size_t k = 0; k < path.step.size(); ++k) {
            path.step_interval[k] = instructions_of(path.step[k], interlock);
            path.step[k].latency = rop_cycles(std::max(path.step[k].latency, path.step_interval[k]), config);
        }
    }
    return table;
}

std::uint32_t operation_lane_cycles(const QuadOperation& quad, const InterlockConfig& config) {
    if (quad.kind == QuadKind::kCulled || (quad.kind == QuadKind::kDraw && quad.pixels == 0)) return 0;
    return 4 * (quad.interval + config.overhead_instructions);
}

std::uint64_t critical_cycles(const QuadOperation& quad, const LineAccess* lines,
                              const MachineConfig& config) {
    const InterlockConfig& c = config.interlock;
    bool loads = false;
    bool stores = false;
    for (std::uint32_t l = 0; l < quad.line_count; ++l) {
        loads |= lines[l].read_sectors != 0;
        stores |= lines[l].write_sectors != 0;
    }
    const std::uint64_t load = c.memory_latency + config.l2.latency + 1;
    const std::uint64_t section = (loads ? load : 0) + quad.latency + (stores ? c.memory_latency : 0);
    // Taking a lock is an atomic more; giving it back is a store that nobody waits for.
    return section + (c.mode == InterlockMode::kSpin ? load : c.begin_cycles + c.end_cycles);
}

MemoryRequest lock_request(const QuadOperation& quad, const SurfaceMap& map, bool gives_back) {
    constexpr std::uint32_t kBytes = 16;  // a word a pixel
    MemoryRequest request;
    request.address = map.address(map.locks(), quad.quad_id / 16, quad.quad_id % 16, 0, 0);
    request.bytes = kBytes;
    request.surface = static_cast<std::uint8_t>(map.locks());
    request.write = gives_back;
    request.cause = gives_back ? MemoryCause::kWriteBack : MemoryCause::kFill;
    return request;
}

QuadBatch* InterlockSource::next() {
    QuadBatch* batch = source_.next();
    if (batch == nullptr) return nullptr;
    for (QuadOperation& quad : batch->quads) quad.shader_lane_cycles += operation_lane_cycles(quad, config_);
    return batch;
}

}  // namespace ropsim
