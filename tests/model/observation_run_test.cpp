// What `ropsim run` tells of a run besides its counters: nothing of it changes the run, and it adds up to
// them.
#include "tests/model/machine_driver.h"

#include <map>
#include <set>

namespace ropsim {
namespace {

using nlohmann::json;

class ObservationRun : public ModelTest {
 protected:
    std::string layers(int layers = 6) const {
        LayeredScene scene;
        scene.width = 160;
        scene.height = 96;
        scene.layers = layers;
        return write_layers(scene);
    }
};

json without_observation(json run) {
    for (const char* key : {"host", "threads", "occupancy", "bottleneck", "bottlenecks"}) run.erase(key);
    return run;
}

TEST_F(ObservationRun, LookingChangesNothing) {
    const std::string trace = layers();
    const Settings settings = {"cache.kibibytes=4", "rop.partitions=3", "clock.shader_mhz=1100",
                               "cache.port_bytes=32"};
    const json often = run(trace, "adaptive:nodes=4", settings, {"--probe-cycles", "1"}, "often");
    const json rarely = run(trace, "adaptive:nodes=4", settings, {"--probe-cycles", "1000000"}, "rarely");
    const json all =
        run(trace, "adaptive:nodes=4", settings,
            {"--timeline", path("t.json"), "--vcd", path("v.vcd"), "--vcd-window", "100:5000"}, "all");
    EXPECT_EQ(often["occupancy"]["slots"]["samples"].get<std::uint64_t>(),
              3 * often["cycles"].get<std::uint64_t>());
    EXPECT_EQ(rarely["occupancy"]["slots"]["samples"], 3);
    EXPECT_EQ(without_observation(often), without_observation(rarely));
    EXPECT_EQ(without_observation(often), without_observation(all));
}

// The rules of the trace-event format: what each phase must have; slices of a thread do not overlap.
std::vector<json> checked_events(const json& timeline) {
    std::vector<json> events;
    std::map<std::pair<int, int>, double> last;
    for (const json& event : timeline["traceEvents"]) {
        const std::string phase = event.at("ph").get<std::string>();
        EXPECT_TRUE(event.at("name").is_string() && event.at("pid").is_number_integer());
        EXPECT_TRUE(event.at("args").is_object());
        if (phase == "M") {
            EXPECT_TRUE(event.at("args").at("name").is_string());
        } else if (phase == "C") {
            EXPECT_TRUE(event.at("ts").is_number());
            for (const auto& [series, value] : event.at("args").items())
                EXPECT_TRUE(value.is_number()) << series;
        } else {
            EXPECT_EQ(phase, "X");
            EXPECT_GE(event.at("dur").get<double>(), 0.0);
            double& end = last[{event["pid"].get<int>(), event.at("tid").get<int>()}];
            EXPECT_GE(event.at("ts").get<double>(), end - 1e-9) << event.dump();
            end = event["ts"].get<double>() + event["dur"].get<double>();
        }
        events.push_back(event);
    }
    return events;
}

TEST_F(ObservationRun, TheTimelineAddsUpToTheRun) {
    const std::string trace = layers(12);
    const Settings settings = {"cache.kibibytes=2", "rop.partitions=3", "cache.port_bytes=32"};
    std::uint64_t coarse = 0;
    for (const char* budget : {"1000", "100000"}) {
        const json r =
            run(trace, "adaptive:nodes=8", settings,
                {"--timeline", path("t.json"), "--timeline-events", budget, "--probe-cycles", "10"});
        const json timeline = json::parse(read_file(path("t.json")));
        const std::vector<json> events = checked_events(timeline);
        EXPECT_LE(events.size(), std::stoull(budget) + 100);
        EXPECT_EQ(timeline["otherData"]["cycles"], r["cycles"]);
        EXPECT_NE(timeline["otherData"]["interval_cycles"], coarse);
        coarse = timeline["otherData"]["interval_cycles"].get<std::uint64_t>();
        std::map<std::string, std::map<std::string, std::uint64_t>> cycles;
        std::uint64_t read = 0;
        std::uint64_t write = 0;
        std::set<std::string> passes;
        for (const json& event : events) {
            const std::string name = event["name"].get<std::string>();
            if (event["ph"] == "X" && event["pid"] == 1 && event["tid"].get<int>() < 100) passes.insert(name);
            if (event["ph"] != "C") continue;
            EXPECT_LE(event["ts"].get<double>(), 1e6 * r["seconds"].get<double>());
            if (name == "pin bytes") {
                read += event["args"]["read"].get<std::uint64_t>();
                write += event["args"]["write"].get<std::uint64_t>();
            } else if (name != "occupied") {
                for (const auto& [label, count] : event["args"].items())
                    cycles[name][label] += count.get<std::uint64_t>();
            }
        }
        EXPECT_EQ(read, r["dram"]["read_bytes"]);
        EXPECT_EQ(write, r["dram"]["write_bytes"]);
        EXPECT_GE(cycles.size(), 4u);
        for (const auto& [stage, counted] : r["stages"].items()) {
            if (!cycles.contains(stage + " cycles")) continue;  // of many instances that are added up
            std::map<std::string, std::uint64_t> expected = counted["stall"];
            expected["busy"] = counted["busy"].get<std::uint64_t>();
            expected["idle"] = counted["idle"].get<std::uint64_t>();
            for (const auto& [label, count] : expected)
                EXPECT_EQ(cycles[stage + " cycles"][label], count) << stage;
        }
        for (const json& pass : r["passes_in_machine"]) EXPECT_TRUE(passes.contains(pass["pass"])) << pass;
    }
}

// Every pass of the frame, in order, inside the run, with all the quads.
TEST_F(ObservationRun, PassesRunOneAfterTheOther) {
    const json r = run(layers(), "stochastic:samples=4", {});
    double start = 0;
    ASSERT_GE(r["passes_in_machine"].size(), 2u);
    for (const json& pass : r["passes_in_machine"]) {
        EXPECT_GE(pass["start_seconds"].get<double>(), start);
        start = pass["start_seconds"].get<double>();
        EXPECT_GT(pass["end_seconds"].get<double>(), start);
        EXPECT_LE(pass["end_seconds"].get<double>(), r["seconds"].get<double>());
        EXPECT_GT(pass["quads"].get<std::uint64_t>(), 0u);
    }
}

TEST_F(ObservationRun, WrongOptionsSaySo) {
    const std::string trace = layers();
    const auto refused = [&](const std::vector<std::string>& more, const std::string& what) {
        std::vector<std::string> arguments = {"run", trace, "--technique", "alpha_blend", "-o", path("no")};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const ProgramResult result = run_program(arguments);
        EXPECT_EQ(result.status, 1) << result.err;
        EXPECT_NE(result.err.find(what), std::string::npos) << result.err;
    };
    refused({"--timeline", path("t.json"), "--fidelity", "cached"}, "--fidelity timed");
    refused({"--vcd", path("v.vcd"), "--vcd-window", "20:10"}, "FROM below TO");
    refused({"--vcd", path("v.vcd"), "--vcd-window", "x"}, "--vcd-window");
    refused({"--vcd", path("v.vcd"), "--vcd-window", "0:2000000"}, "shorter");
    refused({"--vcd", path("no-such-directory/v.vcd")}, "no-such-directory");
    refused({"--timeline", trace}, "is also an input");
    refused({"--timeline", path("same"), "--vcd", path("same")}, "--timeline");
}

}  // namespace
}  // namespace ropsim
