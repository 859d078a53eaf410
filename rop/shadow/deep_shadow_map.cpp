#include "rop/shadow/deep_shadow_map.h"

#include "base/error.h"
#include "base/parallel.h"
#include "traces/depth_test.h"

#include <algorithm>
#include <numeric>

namespace ropsim {

DeepShadowMap::DeepShadowMap(TraceReader& light, int threads)
    : DeepShadowMap(
          light, kLeastAlpha, [](const Fragment& f, const Material&) { return static_cast<double>(f.a); },
          true, threads) {}

DeepShadowMap::DeepShadowMap(TraceReader& light, const Opacity& opacity, bool opaque_blocks, int threads)
    : DeepShadowMap(light, kMaterialChannels, opacity, opaque_blocks, threads) {}

DeepShadowMap::DeepShadowMap(TraceReader& light, unsigned channels, const Opacity& opacity,
                             bool opaque_blocks, int threads)
    : width_(light.header().width), height_(light.header().height) {
    CHECK(light.header().samples == 1, "a light view of {} samples a pixel", light.header().samples);
    if (light.header().opaque && opaque_blocks) opaque_ = light.header().opaque->depth;
    gather(light, channels, opacity);
    sort_and_multiply(threads);
}

// Counts each texel's fragments in a first pass, puts them there in a second.
void DeepShadowMap::gather(TraceReader& light, unsigned channels, const Opacity& opacity) {
    const OpaqueDepthTest test(light.header());
    FragmentChunk chunk;
    const Material plain;
    const auto for_each_visible = [&](unsigned wanted, const auto& work) {
        light.rewind();
        while (light.next(chunk, wanted))
            for (std::size_t i = 0; i < chunk.size(); ++i)
                if (test.visible_samples(chunk.fragments[i], {}) != 0)
                    work(chunk.fragments[i], chunk.materials.empty() ? plain : chunk.materials[i]);
    };
    start_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) + 1, 0);
    for_each_visible(kNoChannels, [&](const Fragment& f, const Material&) { ++start_[texel(f.x, f.y) + 1]; });
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    steps_.resize(start_.back());
    std::vector<std::uint64_t> next(start_.begin(), start_.end() - 1);
    for_each_visible(channels, [&](const Fragment& f, const Material& m) {
        steps_[next[texel(f.x, f.y)]++] = {f.z, 1.0 - opacity(f, m)};
    });
    light.rewind();
}

void DeepShadowMap::sort_and_multiply(int threads) {
    parallel_for(threads, height_, [&](int y) {
        for (int x = 0; x < width_; ++x) {
            const auto first = steps_.begin() + static_cast<std::ptrdiff_t>(start_[texel(x, y)]);
            const auto last = steps_.begin() + static_cast<std::ptrdiff_t>(start_[texel(x, y) + 1]);
            // Arrival decides between equal depths, so that products round the same way every time.
            std::stable_sort(first, last, [](const Step& a, const Step& b) { return a.z < b.z; });
            double transmittance = 1;
            for (auto step = first; step != last; ++step) step->behind = transmittance *= step->behind;
        }
    });
}

double DeepShadowMap::visibility(int x, int y, double z) const {
    if (static_cast<double>(opaque_depth(x, y)) < z) return 0;
    const auto first = steps_.begin() + static_cast<std::ptrdiff_t>(start_[texel(x, y)]);
    const auto last = steps_.begin() + static_cast<std::ptrdiff_t>(start_[texel(x, y) + 1]);
    const auto nearer =
        std::partition_point(first, last, [z](const Step& s) { return static_cast<double>(s.z) < z; });
    return nearer == first ? 1.0 : (nearer - 1)->behind;
}

double DeepShadowMap::total_alpha(int x, int y) const {
    const std::uint64_t end = start_[texel(x, y) + 1];
    return end == start_[texel(x, y)] ? 0.0 : 1.0 - steps_[end - 1].behind;
}

DeepShadowMap::DepthMean DeepShadowMap::depth_kept(int x, int y, double empty) const {
    DepthMean kept;
    double reaching = 1;
    for (std::uint64_t i = start_[texel(x, y)]; i < start_[texel(x, y) + 1]; ++i) {
        const auto z = static_cast<double>(steps_[i].z);
        const double taken = reaching - steps_[i].behind;
        kept.mean += taken * z;
        kept.square += taken * z * z;
        reaching = steps_[i].behind;
    }
    kept.mean += reaching * empty;
    kept.square += reaching * empty * empty;
    return kept;
}

}  // namespace ropsim
