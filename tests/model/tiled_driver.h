// What the tests of the tiled engine share: runs of either engine, and scenes.
#pragma once

#include "model/run.h"
#include "tests/model/machine_driver.h"

#include <string>
#include <utility>
#include <vector>

namespace ropsim {

inline RunResult run_with(const std::string& trace, const std::string& technique, Engine engine,
                          Fidelity fidelity, const Settings& settings = {}, int threads = 1) {
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

class TiledEngineTest : public ModelTest {
 protected:
    std::string write_random(const RandomFragments& scene, const std::string& name = "trace") const {
        TraceWriter writer(path(name), random_header(scene));
        writer.append(random_chunk(scene));
        writer.finish();
        return path(name);
    }
    // A screen of which every pixel is covered `layers` times, each layer one primitive, over an opaque
    // layer.
    std::string write_full(int width, int height, int layers, bool opaque) const {
        TraceHeader header = plain_header(width, height);
        if (opaque) {
            const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
            header.opaque =
                OpaqueLayer{std::vector<float>(3 * pixels, 0.5f), std::vector<float>(pixels, 0.9f)};
        }
        std::vector<Fragment> fragments;
        for (int layer = 0; layer < layers; ++layer)
            for (int y = 0; y < height; y += 2)
                for (int x = 0; x < width; x += 2)
                    for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}})
                        fragments.push_back(fragment_at(x + u, y + v,
                                                        0.8f - 0.01f * static_cast<float>(layer),
                                                        static_cast<std::uint32_t>(layer)));
        return write(header, fragments, "full");
    }
};

}  // namespace ropsim
