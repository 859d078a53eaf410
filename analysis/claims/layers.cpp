// Pixels with a given number of layers.
#include "analysis/claims/layers.h"

#include "base/error.h"
#include "base/random.h"
#include "traces/generators.h"

#include <cstdio>
#include <vector>

namespace ropsim {
namespace {

Fragment random_layer(const ClaimTrace& trace, std::uint64_t key) {
    Fragment f{};
    f.z = random_unit(key, 0);
    f.a = trace.alpha > 0 ? static_cast<float>(trace.alpha) : random_unit(key, 1);
    f.r = f.a * random_unit(key, 2);
    f.g = f.a * random_unit(key, 3);
    f.b = f.a * random_unit(key, 4);
    return f;
}

Fragment black_or_white(const ClaimTrace& trace, int layer) {
    Fragment f{};
    f.z = static_cast<float>(layer + 1) / static_cast<float>(trace.layers + 1);
    f.a = static_cast<float>(trace.alpha);
    if (layer == trace.layers - 1) f.r = f.g = f.b = f.a;
    return f;
}

}  // namespace

void write_layers(const std::string& path, const ClaimTrace& trace, bool quick) {
    TraceHeader header;
    const std::string size = trace.size_of(quick);
    CHECK(std::sscanf(size.c_str(), "%dx%d", &header.width, &header.height) == 2, "{}", size);
    header.scene = trace.name(quick);
    header.draws.resize(1);
    std::vector<Fragment> fragments;
    constexpr std::uint64_t kSeed = 17;
    for (int pixel = 0; pixel < header.width * header.height; ++pixel) {
        for (int layer = 0; layer < trace.layers; ++layer) {
            const std::uint64_t key = mix64(kSeed + static_cast<std::uint64_t>(pixel * trace.layers + layer));
            Fragment f = trace.scene == "layers" ? random_layer(trace, key) : black_or_white(trace, layer);
            f.x = static_cast<std::uint16_t>(pixel % header.width);
            f.y = static_cast<std::uint16_t>(pixel / header.width);
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
