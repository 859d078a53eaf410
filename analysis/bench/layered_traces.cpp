// Layers from the generator in the corner of an image.
#include "analysis/bench/layered_traces.h"

#include "traces/generators.h"

#include <fmt/format.h>

namespace ropsim {

std::string layered_trace(const std::string& directory, const LayeredSize& size) {
    return fmt::format("{}/layers-{}-{}-{}.trace", directory, size.covered, size.layers, size.image);
}

void make_layered_trace(const std::string& file, const LayeredSize& size) {
    LayeredScene scene;
    scene.width = scene.height = size.covered;
    scene.layers = size.layers;
    TraceHeader header = layered_header(scene);
    header.width = header.height = size.image;
    TraceWriter writer(file, header);
    append_layered(scene, writer);
    writer.finish();
}

}  // namespace ropsim
