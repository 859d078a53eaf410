#include "rop/shadow/filter_cost.h"

#include "rop/shadow/shadow_filter.h"
#include "rop/shadow/variance_shadow_map.h"

namespace ropsim {

namespace {

// Texels of one axis that a pass with `taps` consecutive ones each `step` texels reads, of `size`.
std::uint64_t distinct_texels(std::uint64_t size, int taps, int step) {
    if (taps >= step) return size;
    const auto kept = static_cast<std::uint64_t>(reduced_size(static_cast<int>(size), step));
    return std::min(size, kept * static_cast<std::uint64_t>(taps));
}

}  // namespace

std::vector<ConversionPass> conversion_passes(const MapShape& map, const VarianceOptions& options) {
    const bool separate = options.passes == ConversionPasses::kSeparate;
    const bool fused = options.passes == ConversionPasses::kFused;
    const int reduced_taps = static_cast<int>(conversion_kernel(options).weights.size());
    const auto tent = static_cast<std::uint64_t>(options.tent);
    const auto step = static_cast<std::uint64_t>(options.downsample);
    const std::uint64_t narrow = (map.width + step - 1) / step;
    const std::uint64_t low = (map.height + step - 1) / step;
    const std::uint64_t texels = map.width * map.height * map.wavelengths;
    const std::uint64_t last = narrow * low * map.wavelengths;
    constexpr std::uint64_t kMoments = DepthMoments::kBytes;
    std::vector<ConversionPass> passes;
    // `per`: stored values that one tap reads.
    const auto add = [&](const char* name, std::uint64_t out, std::uint64_t taps, std::uint64_t per,
                         std::uint64_t bytes, std::uint64_t distinct) {
        passes.push_back(
            {name, out, out * taps * per, out * taps * per * bytes, distinct * per * bytes, out * kMoments});
    };
    if (!fused) add("moments", texels, 1, map.samples, map.depth_bytes, texels);
    if (separate) {
        add("tent_across", texels, tent, 1, kMoments, texels);
        add("tent_down", texels, tent, 1, kMoments, texels);
        const bool mean = options.reduction == Reduction::kMean;
        if (options.downsample > 1)
            add("downsample", last, mean ? step * step : 1, 1, kMoments, mean ? texels : last);
        return passes;
    }
    const auto taps = static_cast<std::uint64_t>(reduced_taps);
    const std::uint64_t half = narrow * map.height * map.wavelengths;
    add("tent_across", half, taps, fused ? map.samples : 1, fused ? map.depth_bytes : kMoments,
        distinct_texels(map.width, reduced_taps, options.downsample) * map.height * map.wavelengths);
    add("tent_down", last, taps, 1, kMoments,
        distinct_texels(map.height, reduced_taps, options.downsample) * narrow * map.wavelengths);
    return passes;
}

LookupCost variance_lookup_cost(const VarianceOptions& options) {
    return {1, static_cast<double>((options.bilinear ? 4 : 1) * DepthMoments::kBytes)};
}

LookupCost direct_lookup_cost(double fetches, const MapShape& map) {
    return {fetches, fetches * static_cast<double>(map.samples * map.depth_bytes)};
}

int disc_texels(int side) {
    ShadowFilter disc;
    disc.side = side;
    disc.shape = FilterShape::kDisc;
    int count = 0;
    for (int y = -side / 2; y <= side / 2; ++y)
        for (int x = -side / 2; x <= side / 2; ++x) count += disc.weight(x, y);
    return count;
}

FilterSaving filter_saving(const MapShape& map, const VarianceOptions& options, double lookups,
                           double direct_fetches, bool cached, bool bilinear_as_one) {
    FilterSaving saving;
    for (const ConversionPass& pass : conversion_passes(map, options))
        saving.conversion_bytes +=
            static_cast<double>((cached ? pass.distinct_bytes : pass.read_bytes) + pass.write_bytes);
    const auto wavelengths = static_cast<double>(map.wavelengths);
    const double fetch_bytes =
        bilinear_as_one ? static_cast<double>(DepthMoments::kBytes) : variance_lookup_cost(options).bytes;
    saving.lookup_bytes = lookups * wavelengths * fetch_bytes;
    saving.direct_bytes = lookups * wavelengths * direct_lookup_cost(direct_fetches, map).bytes;
    return saving;
}

double lookups_for_saving(const MapShape& map, const VarianceOptions& options, double ratio,
                          double direct_fetches, bool cached, bool bilinear_as_one) {
    const FilterSaving one = filter_saving(map, options, 1, direct_fetches, cached, bilinear_as_one);
    const double gain = one.direct_bytes - ratio * one.lookup_bytes;
    return gain > 0 ? ratio * one.conversion_bytes / gain : -1;
}

}  // namespace ropsim
