// Layers of random colour and depth in every pixel.
#include "analysis/claims_layers.h"

#include "base/error.h"
#include "base/random.h"
#include "traces/generators.h"

#include <cstdio>
#include <vector>

namespace ropsim {

void write_layers(const std::string& path, const ClaimTrace& trace, bool quick) {
    const int side = quick ? 32 : 64;
    TraceHeader header;
    header.width = side;
    header.height = side;
    header.scene = trace.name(quick);
    header.draws.resize(1);
    std::vector<Fragment> fragments;
    constexpr std::uint64_t kKey = 17;
    for (int pixel = 0; pixel < side * side; ++pixel) {
        for (int layer = 0; layer < trace.layers; ++layer) {
            const std::uint64_t key = mix64(kKey + static_cast<std::uint64_t>(pixel * 64 + layer));
            Fragment f{};
            f.x = static_cast<std::uint16_t>(pixel % side);
            f.y = static_cast<std::uint16_t>(pixel / side);
            f.z = random_unit(key, 0);
            f.a = trace.alpha > 0 ? static_cast<float>(trace.alpha) : random_unit(key, 1);
            f.r = f.a * random_unit(key, 2);
            f.g = f.a * random_unit(key, 3);
            f.b = f.a * random_unit(key, 4);
            f.primitive = static_cast<std::uint32_t>(layer);
            f.coverage = 1;
            fragments.push_back(f);
        }
    }
    write_trace(path, header, fragments);
}

void write_surfaces(const std::string& path, const ClaimTrace& trace, bool quick) {
    LayeredScene scene;
    const std::string size = trace.size_of(quick);
    CHECK(std::sscanf(size.c_str(), "%dx%d", &scene.width, &scene.height) == 2, "{}", size);
    scene.layers = trace.layers;
    scene.samples = trace.samples;
    scene.alpha = static_cast<float>(trace.alpha);
    // Small triangles: with 4 samples a pixel about a tenth more fragments, as edges make them.
    scene.cell = 12;
    TraceWriter writer(path, layered_header(scene));
    append_layered(scene, writer);
    writer.finish();
}

}  // namespace ropsim
