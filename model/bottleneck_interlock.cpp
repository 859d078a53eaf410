// What a run of engine `shader` spent its time on, in words: its quads wait in the shader cores' places. See
// bottleneck_summary.h.
#include "model/bottleneck_summary.h"

#include <algorithm>

#include <fmt/format.h>

namespace ropsim {

namespace {

const StageAccount* account_of(const MachineResult& result, const char* name) {
    const auto found = std::ranges::find(result.stages, name, &StageReport::name);
    return found == result.stages.end() ? nullptr : &found->account;
}

std::string sentence(double share, const std::string& text) {
    return fmt::format("{:.0f}% of the cycles of the places for quads {}", 100 * share, text);
}

// What keeps places without a quad that is shaded.
std::string unused_places(const MachineResult& r, const MachineConfig& c) {
    const StageAccount* rasteriser = account_of(r, "rasteriser");
    const StageAccount* front_end = account_of(r, "front_end");
    const auto part = [&](const StageAccount* account, StageLabel label) {
        return account == nullptr || r.rop_cycles == 0 ? 0.0
                                                       : 100.0 * static_cast<double>(account->cycles(label)) /
                                                             static_cast<double>(account->labelled());
    };
    return fmt::format(
        "are not held by a shaded quad: the shader ALUs are busy {:.0f}% of the time "
        "(shader.alu_lanes = {}), the rasteriser {:.0f}%, and held back {:.0f}% by a full window or full "
        "cores; a full queue, window "
        "or core stops the export in {:.0f}%",
        100 * r.alu_utilisation, c.shader_alu_lanes, part(rasteriser, StageLabel::kBusy),
        part(rasteriser, StageLabel::kSlotsFull), part(front_end, StageLabel::kRopQueueFull));
}

}  // namespace

std::vector<CycleCause> interlock_bottlenecks(const MachineResult& result, const MachineConfig& config) {
    const StageAccount* places = account_of(result, "interlock_quads");
    const StageAccount* port = account_of(result, "interlock_port");
    if (places == nullptr || port == nullptr || places->labelled() == 0 || result.quads == 0) return {};
    std::vector<CycleCause> list;
    const auto quads = static_cast<double>(result.quads);
    const auto add = [&](const char* cause, StageLabel label, const std::string& text) {
        const double share =
            static_cast<double>(places->cycles(label)) / static_cast<double>(places->labelled());
        if (share > 0) list.push_back({cause, share, sentence(share, text)});
    };
    const auto each = [&](StageLabel label) { return static_cast<double>(places->cycles(label)) / quads; };
    const double section = each(StageLabel::kRequestQueue) + each(StageLabel::kFill) +
                           each(StageLabel::kBusy) + each(StageLabel::kStores);
    const double busy = 100.0 * static_cast<double>(port->cycles(StageLabel::kBusy)) /
                        static_cast<double>(std::max<std::uint64_t>(port->labelled(), 1));
    std::string waits = fmt::format(
        "wait for pixels that other quads have: {:.0f} cycles a quad, where a critical section takes {:.0f} "
        "(interlock.memory_latency = {}, interlock.granularity)",
        each(StageLabel::kInterlock), section, config.interlock.memory_latency);
    if (config.interlock.mode == InterlockMode::kSpin && result.interlock)
        waits += fmt::format("; {:.1f} tries an operation, {:.0f}% of the ports' cycles are taken",
                             static_cast<double>(result.interlock->tries) / quads, busy);
    add("interlock", StageLabel::kInterlock, waits);
    add("port", StageLabel::kRequestQueue,
        fmt::format("wait for the port to the L2, a request a cycle: it is busy {:.0f}% of the time", busy));
    add("loads", StageLabel::kFill,
        fmt::format("wait for loads: {:.0f} cycles a quad (interlock.memory_latency = {}, l2.latency = {}), "
                    "DRAM data buses busy {:.0f}% of the time",
                    each(StageLabel::kFill), config.interlock.memory_latency, config.l2.latency,
                    100 * result.dram_utilisation));
    add("operation", StageLabel::kBusy,
        fmt::format("execute operations, begin or end a section: {:.0f} cycles a quad "
                    "(interlock.instruction_latency = {})",
                    each(StageLabel::kBusy), config.interlock.instruction_latency));
    add("stores", StageLabel::kStores,
        fmt::format("wait for word of their stores: {:.0f} cycles a quad (interlock.memory_latency = {})",
                    each(StageLabel::kStores), config.interlock.memory_latency));
    add("front_end", StageLabel::kIdle, unused_places(result, config));
    std::ranges::stable_sort(list, std::ranges::greater(), &CycleCause::share);
    return list;
}

}  // namespace ropsim
