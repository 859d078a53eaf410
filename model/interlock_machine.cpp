#include "model/interlock_machine.h"

namespace ropsim {

void collect_interlocks(const InterlockPartitions& partitions, MachineResult& result) {
    result.interlock.emplace();
    for (const auto& p : partitions) {
        result.quads += p->quads();
        result.interlock->tries += p->tries();
        result.interlock->retries += p->retries();
        for (std::size_t s = 0; s < p->bytes().size(); ++s) {
            result.read_latency[s].add(p->read_latency()[s]);
            for (std::size_t c = 0; c < kMemoryCauses; ++c) {
                result.miss_port[s][c].read += p->bytes()[s][c].read;
                result.miss_port[s][c].write += p->bytes()[s][c].write;
            }
        }
    }
}

std::vector<StageReport> interlock_stages(const InterlockPartitions& partitions, const MachineConfig& config,
                                          std::uint64_t total) {
    StageReport quads{"interlock_quads", {}, config.shader_quads_in_flight};
    StageReport ports{"interlock_port", {}, static_cast<std::uint32_t>(partitions.size())};
    for (const auto& p : partitions) {
        ports.account.add(p->port_account());
        for (std::size_t l = 0; l < p->quad_cycles().size(); ++l)
            quads.account.charge(quads.account.labelled() + p->quad_cycles()[l], static_cast<StageLabel>(l));
    }
    quads.account.finish(total * quads.instances);
    return {quads, ports};
}

}  // namespace ropsim
