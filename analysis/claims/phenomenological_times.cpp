// Run times of McGuire and Mara 2017: Table 1, cell by cell.
#include "analysis/claims/phenomenological.h"

#include <initializer_list>
#include <limits>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr double kScreenPixels = 1920.0 * 1080;

// Table 1, GeForce 980, 1920x1080: shadow map and VSM, OIT, resolve.
struct TimeRow {
    const char* id;
    const char* name;
    const char* printed;
    const char* scene;  // ours of the kind; null: none
    const char* technique;
};
constexpr TimeRow kTimes[] = {
    {"door", "Door", "0.01 + 1.55, 0.04, 2.37", nullptr, ""},
    {"glasses", "Glasses", "0.73 + 4.65, 1.53, 0.09", nullptr, ""},
    {"foggy-night", "Foggy Night", "0.37 + 1.55, 4.32, 4.02", "fog", "phenomenological"},
    {"foggy-night-4x4", "Foggy Night with 4x4 subsampling", "0.37 + 1.55, 0.37, 5.01", "fog",
     "phenomenological:low_resolution=4,low_draws=fog"},
    {"chess", "Chess", "0.24 + 4.65, 6.21, 0.09", "glass", "phenomenological"},
    {"engine", "Engine", "0.48 + 1.55, 10.0, 0.07", "engine", "phenomenological"},
    {"hair", "Hair", "28.13 + 1.55, 19.21, 0.06", "hair", "phenomenological"},
    {"car", "Car", "0.68 + 1.55, 2.91, 0.11", nullptr, ""},
    {"car-4x4", "Car with 4x4 subsampling", "0.68 + 1.55, 0.25, 1.10", nullptr, ""},
    {"san-miguel", "San Miguel", "5.07 + 1.55, 0.54, 0.09", nullptr, ""}};

double milliseconds(const RunRecord& record, std::initializer_list<const char*> passes) {
    const double pixels = number_of(record.width) * number_of(record.height);
    double seconds = 0;
    for (const char* pass : passes)
        if (const auto found = record.pass_seconds.find(pass); found != record.pass_seconds.end())
            seconds += found->second;
    return 1e3 * seconds * kScreenPixels / pixels;
}

Finding table1_time(const TimeRow& row, ClaimRuns& runs) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const Printed printed = Printed::numbers_of(row.printed);
    Finding finding;
    // No number of ours stands for the paper's scene: there is nothing to judge.
    finding.readings = {{"the paper's scene", std::vector<double>(printed.numbers.size(), kNone)}};
    if (row.scene == nullptr) {
        finding.why = "not judged: no such scene, and none here is of the kind";
        return finding;
    }
    ClaimRun run{{row.scene, "320x180", "160x90"}, row.technique};
    run.fidelity = "timed";
    run.hardware = "gtx980";
    const RunRecord& record = runs.run(run);
    const double oit = milliseconds(record, {"accumulate", "low_resolution"});
    const double resolve = milliseconds(record, {"upsample", "resolve"});
    finding.measured = {oit, resolve};
    finding.why = fmt::format(
        "not judged: no such scene. Measured on our {}: {:.2f} ms of OIT and {:.2f} of resolve, where "
        "{:.2f} and {:.2f} are printed, simulated at a small size and scaled by pixels, without shadow maps",
        row.scene, oit, resolve, printed.numbers[2].value, printed.numbers[3].value);
    return finding;
}

void add_times(std::vector<Claim>& claims) {
    for (const TimeRow& row : kTimes)
        claims.push_back({fmt::format("mm-table1-{}", row.id), kPhenomenologicalPaper, "Table 1",
                          fmt::format("Milliseconds of {}: shadow map and VSM, OIT, resolve", row.name),
                          Printed::numbers_of(row.printed), rule::digits(), Basis::kAssets,
                          "simulated milliseconds of OIT and resolve on gtx980, of our scene of the kind",
                          row.scene != nullptr, [&row](ClaimRuns& runs) { return table1_time(row, runs); }});
    claims.push_back({"mm-ray-tracer", kPhenomenologicalPaper, "section 8.2",
                      "About an order of magnitude faster for transparency than a ray tracer",
                      Printed::meaning("an order of magnitude", 10, 5), rule::digits(), Basis::kAssets,
                      "not measured: there is no ray tracer here", false, [](ClaimRuns&) {
                          return Finding{
                              {},
                              {},
                              {{"a ray tracer", {std::numeric_limits<double>::quiet_NaN()}}},
                              "not judged: no such ray tracer, which like the scenes is not named"};
                      }});
}

}  // namespace

void add_phenomenological_time_claims(std::vector<Claim>& claims) {
    add_times(claims);
}

}  // namespace ropsim
