// What a trace is like: depth complexity, alpha, and what the opaque layer hides.
#include "traces/trace_statistics.h"

#include <algorithm>

namespace ropsim {

namespace {

DepthComplexity depth_complexity(const std::vector<std::uint32_t>& layers) {
    DepthComplexity result;
    result.max = *std::max_element(layers.begin(), layers.end());
    result.histogram.resize(result.max + 1);
    std::uint64_t fragments = 0;
    for (const std::uint32_t count : layers) {
        ++result.histogram[count];
        fragments += count;
    }
    result.covered_pixels = layers.size() - result.histogram[0];
    if (result.covered_pixels != 0)
        result.mean = static_cast<double>(fragments) / static_cast<double>(result.covered_pixels);
    return result;
}

}  // namespace

TraceStatistics measure_trace(TraceReader& reader) {
    const TraceHeader& header = reader.header();
    const auto width = static_cast<std::size_t>(header.width);
    std::vector<std::uint32_t> all(width * static_cast<std::size_t>(header.height));
    std::vector<std::uint32_t> visible(all.size());
    TraceStatistics result;
    result.draw_fragments.resize(header.draws.size());
    double alpha_sum = 0;
    std::vector<Fragment> chunk;
    reader.rewind();
    while (reader.next(chunk)) {
        for (const Fragment& f : chunk) {
            const std::size_t pixel = f.y * width + f.x;
            const bool hidden =
                header.opaque && header.draws[f.draw].depth_test && !(f.z < header.opaque->depth[pixel]);
            ++all[pixel];
            visible[pixel] += hidden ? 0 : 1;
            result.hidden_by_opaque += hidden ? 1 : 0;
            ++result.draw_fragments[f.draw];
            ++result.alpha_histogram[std::min<std::size_t>(9, static_cast<std::size_t>(f.a * 10.0f))];
            result.zero_alpha += f.a == 0.0f ? 1 : 0;
            result.full_alpha += f.a == 1.0f ? 1 : 0;
            alpha_sum += static_cast<double>(f.a);
        }
        result.fragments += chunk.size();
    }
    reader.rewind();
    if (result.fragments != 0) result.alpha_mean = alpha_sum / static_cast<double>(result.fragments);
    result.all = depth_complexity(all);
    result.visible = depth_complexity(visible);
    return result;
}

}  // namespace ropsim
