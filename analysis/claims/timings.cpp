// The run times that the papers print as ratios, as rows: published_timings.h, simulated at a part of the
// size.
#include "analysis/claims/list.h"
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

// Machine, techniques and engines of both times.
std::string how_of(const PublishedTiming& timing) {
    const auto shown = [](const TimedRun& run) {
        const bool sharp = run.technique.find("diffusion=off") != std::string::npos;
        return fmt::format("{} in the {} engine{}", run.technique, run.engine,
                           sharp ? ", diffusion off" : "");
    };
    return fmt::format("simulated on {}, at half the paper's size each way: {}, against {}",
                       timing.time.run.hardware, shown(timing.time.run), shown(timing.base.run));
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
            how_of(timing),
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

TimedRun slab_paper_run(const std::string& technique, const std::string& engine) {
    return {"forest", "1920x1080", 1, technique, "titan_x", engine};
}

// The times themselves: ours are of other scenes and of a quarter of the pixels.
void add_times(std::vector<Claim>& claims, const std::string& id, const std::string& paper,
               const std::string& place, const std::string& claim, const std::string& printed,
               const std::vector<TimeOf>& times) {
    claims.push_back(
        {id, paper, place, claim, Printed::numbers_of(printed), rule::digits(), Basis::kAssets,
         fmt::format("simulated on {}, at half the paper's size each way", times.front().run.hardware), true,
         [times](ClaimRuns& runs) {
             std::vector<double> ours;
             for (const TimeOf& time : times)
                 ours.push_back(milliseconds(runs.run(run_of(time.run)), time.passes));
             const std::string scene = times.front().run.scene;
             return Finding{{},
                            ours,
                            {{"our scene " + scene, ours}},
                            fmt::format("our scene {} at {}; ratios are in the rows time-*", scene,
                                        run_of(times.front().run).trace.size_of(runs.quick()))};
         }});
}

void add_milliseconds(std::vector<Claim>& claims) {
    const std::string depth_based = "stochastic:samples=8,method=depth_based,masks=table";
    for (const auto& [scene, printed] :
         {std::pair{"motor", "3.6, 3.3, 2.7, 3.4"}, std::pair{"dog", "14.7, 8.6, 8.7, 9.5"},
          std::pair{"windy_hill", "9.5, 6.9, 7.0, 6.9"}}) {
        const TimedRun base{scene, "500x500", 8, "alpha_blend", "fermi", "rop"};
        const TimedRun passes{scene, "500x500", 8, depth_based, "fermi", "rop"};
        add_times(claims, fmt::format("st-table1-ms-{}", scene), "Enderton et al. 2011", "Table 1",
                  fmt::format("Milliseconds of base, total alpha, stochastic depth, accumulation, {}", scene),
                  printed,
                  {{base, {"blend"}},
                   {passes, {"total_alpha"}},
                   {passes, {"stochastic_depth"}},
                   {passes, {"accumulate"}}});
    }
    const std::string normalised = ",composite=normalised";
    add_times(claims, "slab-ms", "Wyman 2016", "section 3",
              "Milliseconds of ST, SLAB and MLAB with 4 and with 8 samples or layers",
              "2.1, 2.5, 3.1, 4.3, 5.5, 8.0",
              {{slab_paper_run("stochastic:samples=4,method=depth_based", "rop"), {}},
               {slab_paper_run("stochastic:samples=8,method=depth_based", "rop"), {}},
               {slab_paper_run("slab:layers=4" + normalised, "shader"), {}},
               {slab_paper_run("slab:layers=8" + normalised, "shader"), {}},
               {slab_paper_run("mlab:layers=4", "shader"), {}},
               {slab_paper_run("mlab:layers=8", "shader"), {}}});
}

void add_five_layers(std::vector<Claim>& claims) {
    claims.push_back(
        {"st-five-layers", "Enderton et al. 2011", "Figure 6",
         "Layers that depth peeling draws in the time of stochastic transparency, windy_hill",
         Printed::meaning("only five layers", 5, 0.5), rule::about(), Basis::kAssets,
         "simulated on fermi, at half the paper's size each way", true, [](ClaimRuns& runs) {
             const auto time = [&](int samples, const char* technique) {
                 const TimedRun run{"windy_hill", "500x500", samples, technique, "fermi", "rop"};
                 return milliseconds(runs.run(run_of(run)), {});
             };
             const double all = time(8, "stochastic:samples=8,method=depth_based,masks=table");
             const double five = time(1, "depth_peeling:layers=5");
             const double layers = 5 * all / five;
             return Finding{
                 {},
                 {layers},
                 {{"our scene windy_hill, preset fermi", {layers}}},
                 fmt::format("{:.3f} ms for all of it, {:.3f} ms for five layers without multisampling; "
                             "whether Figure 6 was multisampled is not printed",
                             all, five)};
         }});
}

}  // namespace

void add_timing_claims(std::vector<Claim>& claims) {
    for (const PublishedTiming& timing : published_timings()) claims.push_back(claim_of(timing));
    add_milliseconds(claims);
    add_five_layers(claims);
}

}  // namespace ropsim
