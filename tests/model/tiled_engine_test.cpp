// The tiled engine: the image of the fixed-function engine, bit for bit, and the bytes that closed forms
// give.
#include "model/run.h"
#include "tests/model/machine_driver.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

namespace ropsim {
namespace {

RunResult run_with(const std::string& trace, const std::string& technique, Engine engine, Fidelity fidelity,
                   const Settings& settings = {}, int threads = 1) {
    RunOptions options;
    options.trace = trace;
    options.technique = technique;
    options.settings = settings;
    options.fidelity = fidelity;
    options.engine = engine;
    options.threads = threads;
    options.error = false;
    return run_simulation(options);
}

std::uint64_t pins(const RunResult& r, const std::string& surface, bool write) {
    const auto at = static_cast<std::size_t>(std::ranges::find(r.surfaces, surface) - r.surfaces.begin());
    std::uint64_t sum = 0;
    for (const CauseBytes& cause : r.machine->pins[at]) sum += write ? cause.write : cause.read;
    return sum;
}

std::uint64_t all_pins(const RunResult& r) {
    std::uint64_t sum = 0;
    for (const std::string& s : r.surfaces) sum += pins(r, s, true) + pins(r, s, false);
    return sum;
}

class TiledEngineTest : public ModelTest {
 protected:
    std::string write_random(const RandomFragments& scene, const std::string& name = "trace") const {
        TraceWriter writer(path(name), random_header(scene));
        writer.append(random_chunk(scene));
        writer.finish();
        return path(name);
    }
};

const std::vector<std::string>& all_techniques() {
    static const std::vector<std::string> techniques = [] {
        std::vector<std::string> list = technique_names();
        list.insert(list.end(),
                    {"stochastic:samples=4", "adaptive:nodes=8", "alpha_blend:image_format=unorm8"});
        return list;
    }();
    return techniques;
}

class TiledTechniqueTest : public TiledEngineTest, public ::testing::WithParamInterface<std::string> {};

// Every technique, with and without room on chip, over an opaque layer and several samples.
TEST_P(TiledTechniqueTest, ImageIsTheFixedFunctionEngines) {
    const std::string technique = GetParam();
    RandomFragments scene;
    scene.seed = 7;
    scene.width = 150;  // more than a region of the trace, and no whole tiles
    scene.height = 44;
    scene.count = 6000;
    scene.draws = 3;
    scene.opaque = true;
    scene.slopes = true;
    const std::string trace = write_random(scene);
    const RunResult rop = run_with(trace, technique, Engine::kRop, Fidelity::kCount);
    for (const Settings& settings :
         {Settings{}, Settings{"tiled.kibibytes=0"}, Settings{"tiled.tile=32", "tiled.kibibytes=12"}}) {
        for (const Fidelity fidelity : {Fidelity::kCount, Fidelity::kCached}) {
            const RunResult tiled = run_with(trace, technique, Engine::kTiled, fidelity, settings,
                                             fidelity == Fidelity::kCount ? 1 : 2);
            EXPECT_EQ(rop.image.values, tiled.image.values)
                << technique << " " << fmt::format("{}", settings);
            EXPECT_EQ(rop.counts.operated, tiled.counts.operated);
            EXPECT_EQ(rop.counts.input, tiled.counts.input);
            EXPECT_EQ(rop.touched_tiles, tiled.touched_tiles);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(All, TiledTechniqueTest, ::testing::ValuesIn(technique_names()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace ropsim
