// The claims of published run times: what they name exists, and each is what its paper says was run.
#include "analysis/published_timings.h"

#include "rop/registry.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

std::set<std::string> passes_of(const TimedRun& run) {
    Screen screen;
    screen.width = 64;
    screen.height = 64;
    screen.samples = run.samples;
    screen.draws = {"fog"};
    screen.materials = true;
    screen.camera = Camera{};
    screen.camera->near_plane = 0.1f;
    screen.camera->far_plane = 100;
    screen.camera->fovy_degrees = 45;
    TechniqueSpec spec = parse_technique(run.technique, "test");
    std::set<std::string> names{"initialise", "resolve", "end_of_frame"};
    const auto operation = make_operation(spec, screen);
    for (const auto& pass : operation->declaration().passes) names.insert(std::string(pass.name));
    return names;
}

const PublishedTiming& timing(const std::string& id) {
    const auto& all = published_timings();
    const auto found = std::ranges::find(all, id, &PublishedTiming::id);
    if (found == all.end()) throw std::runtime_error("no timing " + id);
    return *found;
}

// A pass that the technique does not have would count as no time.
TEST(PublishedTimings, NamePassesThatTheirTechniquesHave) {
    std::set<std::string> ids;
    for (const PublishedTiming& t : published_timings()) {
        EXPECT_TRUE(ids.insert(t.id).second) << t.id;
        EXPECT_GT(t.printed, 0) << t.id;
        for (const TimeOf* time : {&t.time, &t.base}) {
            const std::set<std::string> has = passes_of(time->run);
            for (const std::string& pass : time->passes)
                EXPECT_TRUE(has.contains(pass)) << t.id << ' ' << pass;
        }
    }
}

// Passes over the geometry: three of stochastic transparency, two of SLAB, as normalised there; one of MLAB.
TEST(PublishedTimings, NormalisedTechniquesPayForTheirFurtherPasses) {
    EXPECT_TRUE(passes_of(timing("slab-st8-st4").time.run).contains("total_alpha"));
    EXPECT_TRUE(passes_of(timing("slab-st8-st4").time.run).contains("accumulate"));
    EXPECT_TRUE(passes_of(timing("slab-slab4-st4").time.run).contains("accumulate"));
    EXPECT_FALSE(passes_of(timing("slab-mlab4-slab4").time.run).contains("accumulate"));
}

}  // namespace
}  // namespace ropsim
