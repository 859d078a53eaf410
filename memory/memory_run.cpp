// Runs a stream of requests and takes the sums.
#include "memory/memory_run.h"

#include <ctime>
#include <utility>

namespace ropsim {
namespace {

// Of this thread's processor time: what else the machine does must not count.
class Stopwatch {
 public:
    // Seconds since the last call.
    double lap() {
        const double now = seconds();
        return now - std::exchange(last_, now);
    }

 private:
    static double seconds() {
        timespec time{};
        ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
    }
    double last_ = seconds();
};

}  // namespace

MemoryRun run_memory(const MemoryConfig& config, RequestSource& source, const MemoryRunOptions& options) {
    MemorySystem system(config, options.needs, options.outstanding);
    MemoryRun run;
    std::vector<AddressRequest> block;
    Stopwatch watch;
    while (source.next(block)) {
        run.host_source_seconds += watch.lap();
        for (AddressRequest& request : block) {
            const DramCycle offered = system.offer(request);
            if (request.needs != 0 || options.outstanding != 0) request.cycle = offered;
        }
        run.requests += block.size();
        run.host_seconds += watch.lap();
        if (options.record) options.record(block);
        watch.lap();
    }
    run.cycles = system.finish();
    run.host_seconds += watch.lap();
    run.seconds = static_cast<double>(run.cycles) * config.dram.tck_ps * 1e-12;
    run.wrapped_requests = system.wrapped_requests();
    run.capacity = system.capacity();
    for (std::uint32_t c = 0; c < system.channels(); ++c) {
        run.channels.push_back(system.statistics(c));
        run.total.add(system.statistics(c));
    }
    return run;
}

}  // namespace ropsim
