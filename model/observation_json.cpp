// Parts of run.json: see observation_json.h.
#include "model/observation_json.h"

#include <nlohmann/json.hpp>

namespace ropsim {

namespace {

using Json = nlohmann::ordered_json;

const MachineObservation* observation_of(const RunResult& r) {
    return r.machine && r.machine->observation.probe_cycles != 0 ? &r.machine->observation : nullptr;
}

}  // namespace

Json bottlenecks_json(const RunResult& r) {
    const MachineObservation* const o = observation_of(r);
    if (o == nullptr) return nullptr;
    Json json = Json::array();
    for (const CycleCause& b : o->bottlenecks)
        json.push_back({{"cause", b.cause}, {"share", b.share}, {"text", b.text}});
    return json;
}

Json occupancy_json(const RunResult& r) {
    const MachineObservation* const o = observation_of(r);
    if (o == nullptr) return nullptr;
    Json json = Json::object();
    for (const OccupancyHistogram& h : o->occupancy)
        json[h.queue] = {{"instances", h.instances},        {"capacity", h.capacity},  {"samples", h.samples},
                         {"every_cycles", o->probe_cycles}, {"mean", h.mean()},        {"max", h.maximum},
                         {"bin_width", h.bin_width},        {"histogram", h.histogram}};
    return json;
}

Json passes_json(const RunResult& r) {
    const MachineObservation* const o = observation_of(r);
    if (o == nullptr) return nullptr;
    Json json = Json::array();
    for (const PassSpan& pass : o->passes)
        json.push_back({{"pass", pass.name},
                        {"quads", pass.quads},
                        {"start_seconds", static_cast<double>(pass.start) * 1e-12},
                        {"end_seconds", static_cast<double>(pass.end) * 1e-12}});
    return json;
}

Json reuse_json(const RunResult& r) {
    const MachineObservation* const o = observation_of(r);
    if (o == nullptr || o->reuse.every == 0) return nullptr;
    Json sizes = Json::array();
    for (const ReuseCounts::Size& size : o->reuse.sizes)
        sizes.push_back({{"bytes", size.bytes}, {"misses", size.misses}});
    return {{"one_line_in", o->reuse.every}, {"reads", o->reuse.reads}, {"sizes", sizes}};
}

}  // namespace ropsim
