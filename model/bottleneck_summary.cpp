// The rules by which counters become causes: see bottleneck_summary.h and docs/where-the-cycles-go.md.
#include "model/bottleneck_summary.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace ropsim {

namespace {

constexpr std::array kInterlockNames = {"pixel", "quad", "tile"};  // by HazardConfig::Interlock

// A resource in use for this share of its time is what others wait for.
constexpr double kSaturated = 0.75;
constexpr double kMostly = 0.5;
// With fewer in a channel it has little to choose from: more requests would help, whatever it spends its time
// on.
constexpr double kManyReads = 4;

double ratio(std::uint64_t part, std::uint64_t whole) {
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

// Below a percent with two digits.
std::string percent(double share) {
    return share < 0.0095 ? fmt::format("{:.2g}%", 100 * share) : fmt::format("{:.0f}%", 100 * share);
}

class Summary {
 public:
    Summary(const MachineResult& result, const MachineConfig& config,
            const std::vector<std::string>& surfaces)
        : r_(result), o_(result.observation), c_(config), surfaces_(surfaces) {
        for (const StageReport& stage : r_.stages) {
            if (stage.name == "rop_operation") operations_ = &stage.account;
            if (stage.name == "front_end") front_end_ = &stage.account;
        }
    }

    std::vector<CycleCause> list() {
        if (operations_ == nullptr || front_end_ == nullptr || total() == 0) return {};
        add_operation();
        add_fills();
        add_interlock();
        add_starved();
        add("finished", ratio(o_.finished_cycles, total()),
            fmt::format(
                "pass in partitions that have no quad left, or never had one, while others of the {} operate "
                "(rop.partition_tiles = {})",
                c_.partitions, c_.partition_tiles));
        add("end_of_frame", ratio(o_.end_cycles, total()),
            fmt::format("pass after the last operation: {} KiB are flushed",
                        bytes_of(MemoryCause::kFlush).write / 1024));
        std::erase_if(list_, [](const CycleCause& b) { return b.share <= 0; });
        std::ranges::stable_sort(list_, std::ranges::greater(), &CycleCause::share);
        return std::move(list_);
    }

 private:
    std::uint64_t total() const { return operations_->labelled(); }
    std::uint64_t cycles(StageLabel label) const { return operations_->cycles(label); }
    double dram_share(DramLabel label) const { return ratio(r_.dram.label(label), r_.dram.bus_cycles); }
    void add(std::string cause, double share, const std::string& text) {
        list_.push_back(
            {std::move(cause), share, fmt::format("{} of the ROPs' cycles {}", percent(share), text)});
    }

    CauseBytes bytes_of(MemoryCause cause) const {
        CauseBytes sum;
        for (const auto& surface : r_.miss_port) {
            sum.read += surface[static_cast<std::size_t>(cause)].read;
            sum.write += surface[static_cast<std::size_t>(cause)].write;
        }
        return sum;
    }

    double mean_of(std::string_view queue) const {
        const auto found = std::ranges::find(o_.occupancy, queue, &OccupancyHistogram::queue);
        return found == o_.occupancy.end() ? 0.0 : found->mean();
    }

    void add_operation() {
        const std::uint64_t busy = cycles(StageLabel::kBusy);
        add("operation", ratio(busy, total()),
            fmt::format("operate on pixels: {} quads of {:.2f} cycles (rop.lanes = {}, rop.adders and so on)",
                        r_.quads, ratio(busy, r_.quads), c_.lanes));
    }

    // The way from one quad to the next on its pixels leads through the cache.
    void add_interlock() {
        const std::uint64_t waits = cycles(StageLabel::kInterlock);
        add("interlock", ratio(waits + o_.interlock_reads, total()),
            fmt::format("wait for an earlier quad on the same pixels to be written, and then for its result: "
                        "{} and {} "
                        "(rop.interlock = {}, cache.hit_latency = {})",
                        percent(ratio(waits, total())), percent(ratio(o_.interlock_reads, total())),
                        kInterlockNames[static_cast<std::size_t>(c_.hazards.interlock)],
                        c_.cache_hit_latency));
    }

    void add_fills();
    std::string memory_limit() const;
    std::string capacity() const;
    void add_starved();
    void add_front_end(double share);

    const MachineResult& r_;
    const MachineObservation& o_;
    const MachineConfig& c_;
    const std::vector<std::string>& surfaces_;
    const StageAccount* operations_ = nullptr;
    const StageAccount* front_end_ = nullptr;
    std::vector<CycleCause> list_;
};

// Of the surface with the largest share the sentence says why; it is the same for all.
void Summary::add_fills() {
    const auto largest = std::ranges::max_element(o_.fill_cycles);
    for (std::size_t s = 0; s < o_.fill_cycles.size(); ++s) {
        if (o_.fill_cycles[s] == 0) continue;
        std::uint64_t read = 0;
        for (const CauseBytes& bytes : r_.miss_port[s]) read += bytes.read;
        std::string text = fmt::format("wait for fills of {} ({:.1f} MiB read)", surfaces_[s],
                                       static_cast<double>(read) / (1 << 20));
        if (largest - o_.fill_cycles.begin() == static_cast<std::ptrdiff_t>(s))
            text += memory_limit() + capacity();
        add("fill." + surfaces_[s], ratio(o_.fill_cycles[s] + o_.fill_reads[s], total()), text);
    }
}

// What keeps fills from coming sooner: the data bus, the banks, too few requests, or the latency of each.
std::string Summary::memory_limit() const {
    const double data = r_.dram_utilisation;
    const double rows = dram_share(DramLabel::kPrecharge) + dram_share(DramLabel::kActivate) +
                        dram_share(DramLabel::kActivationWindow);
    const double turnaround = dram_share(DramLabel::kTurnaround);
    const double busy = 1 - dram_share(DramLabel::kIdle) - dram_share(DramLabel::kWriteWait);
    const double held = ratio(o_.waits.fill_reads, o_.waits.fill);
    const double mshrs = ratio(o_.waits.fill_mshrs_full, o_.waits.fill);
    const double slots = ratio(o_.waits.fill_slots_full, o_.waits.fill);
    if (data >= kSaturated)
        return fmt::format("; DRAM bandwidth bounds them: the data buses are busy {} of the time",
                           percent(data));
    if (busy >= kSaturated && held >= kManyReads) {
        const char* const what = data >= std::max(rows, turnaround) ? "bandwidth bounds"
                                 : rows >= turnaround               ? "banks bound"
                                                                    : "turnarounds bound";
        return fmt::format(
            "; DRAM {} them: with {:.1f} reads in a channel, {} of its time goes into data, {} into "
            "opening and closing rows, {} into turning the bus",
            what, held, percent(data), percent(rows), percent(turnaround));
    }
    if (mshrs >= kMostly)
        return fmt::format(
            "; {} miss register{} hold{} back more: all taken in {} of the samples that wait, DRAM "
            "data buses busy {} of the time (cache.mshrs)",
            c_.mshrs, c_.mshrs == 1 ? "" : "s", c_.mshrs == 1 ? "s" : "", percent(mshrs), percent(data));
    if (slots >= kMostly)
        return fmt::format(
            "; {} quads in flight hold back more: all taken in {} of the samples that wait, DRAM "
            "data buses busy {} of the time (rop.quads_in_flight)",
            c_.quads_in_flight, percent(slots), percent(data));
    return fmt::format(
        "; their latency bounds them: {:.1f} of {} miss registers taken and {:.1f} reads in the "
        "channel in the mean of the samples that wait, DRAM data buses busy {} of the time",
        ratio(o_.waits.fill_mshrs, o_.waits.fill), c_.mshrs, held, percent(data));
}

// The smallest cache that would halve the misses of lines used before, if there is one.
std::string Summary::capacity() const {
    const ReuseCounts& reuse = o_.reuse;
    if (reuse.reads < 100 || reuse.sizes.empty()) return "";
    const std::uint64_t now = reuse.sizes.front().misses;
    if (ratio(now, reuse.reads) < 0.02) return "";
    for (const ReuseCounts::Size& size : reuse.sizes) {
        if (2 * size.misses > now) continue;
        return fmt::format(
            "; {} KiB more ROP cache a partition would hold {} of the lines that come back instead of "
            "{} (LRU distances of one line in {})",
            (size.bytes - reuse.sizes.front().bytes + 1023) / 1024,
            percent(1 - ratio(size.misses, reuse.reads)), percent(1 - ratio(now, reuse.reads)), reuse.every);
    }
    return "";
}

// Idle cycles before the last quad, and those in which operands were read for a quad that had waited for
// nothing, with none before it to operate on meanwhile: shared out as the samples found the tag stage.
void Summary::add_starved() {
    std::uint64_t idle = cycles(StageLabel::kIdle) - o_.finished_cycles - o_.end_cycles +
                         cycles(StageLabel::kCacheRead) - o_.interlock_reads;
    for (const std::uint64_t reads : o_.fill_reads) idle -= reads;
    std::uint64_t samples = 0;
    for (const std::uint64_t s : o_.waits.starved) samples += s;
    if (samples == 0) {
        add("idle", ratio(idle, total()), "have no quad to operate on (too few samples to say why)");
        return;
    }
    const auto part = [&](StageLabel label) {
        return ratio(idle, total()) * ratio(o_.waits.starved[static_cast<std::size_t>(label)], samples);
    };
    add_front_end(part(StageLabel::kIdle));
    add("tags.busy", part(StageLabel::kBusy),
        fmt::format("wait for the tag look-ups of the next quad, {} line{} a cycle (cache.ports)",
                    c_.cache_ports, c_.cache_ports == 1 ? "" : "s"));
    add("tags.slots_full", part(StageLabel::kSlotsFull),
        fmt::format("wait for one of {} quads in flight to be written (rop.quads_in_flight, cache.ports)",
                    c_.quads_in_flight));
    add("tags.mshrs_full", part(StageLabel::kMshrsFull),
        fmt::format("wait for one of {} miss registers to be free for the next quad's lines (cache.mshrs)",
                    c_.mshrs));
    add("tags.request_queue", part(StageLabel::kRequestQueue),
        fmt::format(
            "wait for room among {} requests to memory for the next quad's lines (cache.request_queue); DRAM "
            "data buses are busy {} of the time",
            c_.cache_request_queue, percent(r_.dram_utilisation)));
    add("tags.cache_ways", part(StageLabel::kCacheWays),
        fmt::format(
            "wait for one of {} ways, all taken by lines in use, for the next quad's lines (cache.ways)",
            c_.cache.ways));
    add("tags.metadata", part(StageLabel::kMetadata),
        "wait for the state of a block that the next quad needs");
    add("tags.eviction_buffer", part(StageLabel::kEvictionBuffer),
        fmt::format(
            "wait for one of {} places for blocks on their way to memory (compression.eviction_buffer)",
            c_.compression.eviction_buffer));
}

// Cycles in which no quad has come from the front end.
void Summary::add_front_end(double share) {
    const double cycles = static_cast<double>(r_.rop_cycles);
    const double shader_cycles =
        cycles * static_cast<double>(c_.rop_period_ps) / static_cast<double>(c_.shader_period_ps);
    const double raster = static_cast<double>(o_.rastered) / (shader_cycles * c_.raster_quads_per_cycle);
    const double exported = static_cast<double>(o_.exported) / (cycles * c_.export_quads_per_cycle);
    const double window = mean_of("shader_window") / c_.shader_quads_in_flight;
    const double queue_full = ratio(front_end_->cycles(StageLabel::kRopQueueFull), front_end_->labelled());
    if (r_.alu_utilisation >= kSaturated)
        add("shading", share,
            fmt::format(
                "wait for shaded quads: the shader ALUs are busy {} of the time (shader.alu_lanes = {})",
                percent(r_.alu_utilisation), c_.shader_alu_lanes));
    else if (raster >= kSaturated)
        add("raster", share,
            fmt::format("wait for quads from the rasteriser: {} of its rate is used "
                        "(shader.raster_quads_per_cycle = {})",
                        percent(raster), c_.raster_quads_per_cycle));
    else if (exported >= kSaturated)
        add("export", share,
            fmt::format(
                "wait for quads to be exported: {} of the rate is used (shader.export_quads_per_cycle = {})",
                percent(exported), c_.export_quads_per_cycle));
    else if (queue_full >= 0.25 && c_.partitions > 1)
        add("uneven_load", share,
            fmt::format(
                "wait for quads behind those of other partitions: a full queue stops the export in {} of the "
                "cycles, the window of {} quads is {} full",
                percent(queue_full), c_.shader_quads_in_flight, percent(window)));
    else if (window >= kSaturated)
        add("shader_latency", share,
            fmt::format(
                "wait for shaded quads: {} of {} in flight on average cover too little of the shaders' "
                "latency of {} cycles (shader.quads_in_flight)",
                static_cast<std::uint64_t>(mean_of("shader_window")), c_.shader_quads_in_flight,
                c_.shader_latency));
    else
        add("front_end", share,
            fmt::format(
                "get no quad from the front end: shader ALUs are busy {} of the time, the rasteriser {}, the "
                "export {}, the window is {} full",
                percent(r_.alu_utilisation), percent(raster), percent(exported), percent(window)));
}

}  // namespace

std::vector<CycleCause> bottleneck_summary(const MachineResult& result, const MachineConfig& config,
                                           const std::vector<std::string>& surfaces) {
    if (config.interlock.executes) return interlock_bottlenecks(result, config);
    return Summary(result, config, surfaces).list();
}

}  // namespace ropsim
