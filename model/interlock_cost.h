// Engine `shader`: the machine and the operations' costs, when pixel shaders execute what ROPs would.
#pragma once

#include "memory/tlm_memory_port.h"
#include "model/machine_config.h"
#include "model/quad_operation.h"
#include "model/surface_map.h"
#include "rop/cost.h"
#include "rop/operation.h"

#include <cstdint>

namespace ropsim {

// The machine with shaders that execute the operations: a quad's four lanes, no ROP cache, nothing cleared
// fast or compressed, and an L2 slice: the configuration's, or where it has none a cache of the ROP cache's
// size and shape with the other properties of l2.*. Throws UserError if such a cache cannot be.
MachineConfig interlock_machine(const MachineConfig& config);

// The operation's cost on the configured machine. Where the ROP executes, on its datapath; where a shader
// does, PathCost::interval is the instructions that a lane issues and latency() the ROP cycles that they take
// from the first to the last: the longest chain of dependent ones at interlock.instruction_latency, but no
// less than a cycle each. Steps of a list likewise.
CostTable executed_cost(const FramebufferOperation& operation, const MachineConfig& config);

// ALU lane cycles of executing a quad's operation in the shader, helper lanes included.
std::uint32_t operation_lane_cycles(const QuadOperation& quad, const InterlockConfig& config);

// ROP cycles from a grant to the release when every load hits the L2 and nothing else is about; without the
// cycle a request that loads and stores take. `lines`: the quad's.
std::uint64_t critical_cycles(const QuadOperation& quad, const LineAccess* lines,
                              const MachineConfig& config);

// The locks of a quad's pixels: taken by an atomic, which answers, and given back by a store.
MemoryRequest lock_request(const QuadOperation& quad, const SurfaceMap& map, bool gives_back);

// Adds the operations' instructions to their quads' shading.
class InterlockSource : public BatchSource {
 public:
    InterlockSource(BatchSource& source, const InterlockConfig& config) : source_(source), config_(config) {}
    QuadBatch* next() override;
    void release(QuadBatch* batch) override { source_.release(batch); }

 private:
    BatchSource& source_;
    const InterlockConfig& config_;
};

}  // namespace ropsim
