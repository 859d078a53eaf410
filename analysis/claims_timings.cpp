// The run times that the papers print as ratios, as rows: published_timings.h, simulated at a part of the
// size.
#include "analysis/claims_list.h"
#include "analysis/published_timings.h"
#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Half the paper's size in each direction, quick an eighth: ratios are what is compared.
ClaimRun run_of(const TimedRun& run) {
    int width = 0;
    int height = 0;
    CHECK(std::sscanf(run.size.c_str(), "%dx%d", &width, &height) == 2, "{}", run.size);
    const auto part = [&](int by) { return fmt::format("{}x{}", width / by, height / by); };
    return {{run.scene, part(2), part(8), run.samples}, run.technique, "timed", run.hardware, run.engine};
}

double milliseconds(const RunRecord& run, const std::vector<std::string>& passes) {
    double seconds = 0;
    for (const auto& [pass, of_pass] : run.pass_seconds)
        if (passes.empty() || std::ranges::find(passes, pass) != passes.end()) seconds += of_pass;
    return run.pass_seconds.empty() ? NAN : 1e3 * seconds;
}

Claim claim_of(const PublishedTiming& timing) {
    const Printed printed =
        Printed::meaning(fmt::format("{:.2f}{}", timing.printed, timing.difference ? " ms" : ""),
                         timing.printed, 0.1 * timing.printed);
    return {"time-" + timing.id,
            timing.paper,
            timing.place,
            timing.claim,
            printed,
            rule::within(0.1),
            Basis::kAssets,
            fmt::format("simulated on {}, at half the paper's size each way", timing.time.run.hardware),
            true,
            [&timing](ClaimRuns& runs) {
                const ClaimRun run = run_of(timing.time.run);
                const double time = milliseconds(runs.run(run), timing.time.passes);
                const double base = milliseconds(runs.run(run_of(timing.base.run)), timing.base.passes);
                const double ours = timing.difference ? time - base : time / base;
                return Finding{
                    {},
                    {ours},
                    {{fmt::format("our scene {}, preset {}, 10 % taken as equal", timing.time.run.scene,
                                  timing.time.run.hardware),
                      {ours}}},
                    fmt::format("{:.3f} and {:.3f} ms at {}; docs/published-timings.md says why they differ",
                                time, base, run.trace.size_of(runs.quick()))};
            }};
}

}  // namespace

void add_timing_claims(std::vector<Claim>& claims) {
    for (const PublishedTiming& timing : published_timings()) claims.push_back(claim_of(timing));
}

}  // namespace ropsim
