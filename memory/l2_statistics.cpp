// Sums over slices of the second-level cache.
#include "memory/l2_statistics.h"

namespace ropsim {

namespace {
void add_bytes(PortBytesByCause& sum, const PortBytesByCause& one) {
    for (std::size_t s = 0; s < sum.size(); ++s) {
        for (std::size_t c = 0; c < sum[s].size(); ++c) {
            sum[s][c].read += one[s][c].read;
            sum[s][c].write += one[s][c].write;
        }
    }
}
}  // namespace

void L2Statistics::add(const L2Statistics& other) {
    cache.add(other.cache);
    reads += other.reads;
    writes += other.writes;
    add_bytes(looked_up, other.looked_up);
    add_bytes(memory, other.memory);
    for (std::size_t l = 0; l < label_cycles.size(); ++l) label_cycles[l] += other.label_cycles[l];
    cycles += other.cycles;
}

}  // namespace ropsim
