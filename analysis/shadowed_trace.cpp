#include "analysis/shadowed_trace.h"

#include "base/parallel.h"
#include "base/random.h"
#include "traces/depth_test.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace ropsim {

namespace {

constexpr std::size_t kPiece = 2048;                 // look-ups that a thread does at a time
constexpr std::size_t kBand = std::size_t{1} << 18;  // of the opaque layer, kept until they are counted

struct Seen {
    bool looked_up = false;
    bool inside = false;
    double estimate = 1;
    double exact = 1;                  // through the filter
    double exact_texel = 1;            // of the point's own texel
    std::uint32_t texels = 0;          // read, inside the map
    std::uint32_t sampled_texels = 0;  // of which the samples were read
};

class ShadowCaster {
 public:
    ShadowCaster(const TraceHeader& camera, const TraceHeader& light, const StoredShadowMap& map,
                 const DeepShadowMap& deep, const ShadowReceiving& receiving)
        : to_light_(camera, light), map_(map), deep_(deep), receiving_(receiving) {
        texel_filter_.bias = receiving.filter.bias;
        texel_filter_.slope_bias = receiving.filter.slope_bias;
        texel_filter_.side = 1;
    }

    // `opaque`: the receiver is an opaque surface.
    Seen look_up(const ViewPoint& point, std::uint64_t key, bool opaque) const {
        Seen seen;
        seen.looked_up = true;
        const ViewPoint at = to_light_(point);
        seen.inside = inside_view(at, map_.width, map_.height);
        if (!seen.inside) return seen;
        const auto exact = [&](int x, int y, double z) { return deep_.visibility(x, y, z); };
        seen.exact = whole_filter(receiving_.filter, map_.width, map_.height, at, exact);
        seen.exact_texel = whole_filter(texel_filter_, map_.width, map_.height, at, exact);
        seen.estimate =
            filtered(receiving_.filter, map_.width, map_.height, at, key, [&](int x, int y, double z) {
                ++seen.texels;
                if (map_.corrected() && opaque) {
                    // The bias reaches as far behind the point as in front of it.
                    const auto surface = opaque_surface_visibility(map_, x, y, z, 2 * at.z - z);
                    if (surface) return *surface;
                }
                ++seen.sampled_texels;
                return map_.corrected() ? corrected_visibility(map_, x, y, z)
                                        : stochastic_visibility(map_, x, y, z);
            });
        return seen;
    }

    // Every number in the order of the look-ups, so that sums do not depend on threads.
    void count(const std::vector<Seen>& all, ShadowLookups& to) const {
        for (const Seen& seen : all) {
            if (!seen.looked_up) continue;
            ++to.count;
            if (!seen.inside) {
                ++to.outside;
                continue;
            }
            to.noise.add(seen.estimate, seen.exact);
            to.all.add(seen.estimate, seen.exact_texel);
            to.exact_sum += seen.exact;
            to.texels += seen.texels;
            to.samples += std::uint64_t{seen.sampled_texels} * static_cast<std::uint64_t>(map_.samples);
            if (!map_.corrected()) continue;
            to.total_alphas += seen.texels;
            to.opaque_depths += seen.texels;
        }
    }

    float light(double visibility) const {
        return static_cast<float>(receiving_.ambient + (1 - receiving_.ambient) * visibility);
    }
    std::uint64_t seed() const { return receiving_.seed * 0x9E3779B97F4A7C15ull; }

 private:
    LightSpace to_light_;
    const StoredShadowMap& map_;
    const DeepShadowMap& deep_;
    const ShadowReceiving& receiving_;
    ShadowFilter texel_filter_;
};

template <typename Work>
void for_each_in_parallel(int threads, std::size_t count, const Work& work) {
    const auto pieces = static_cast<int>((count + kPiece - 1) / kPiece);
    parallel_for(threads, pieces, [&](int piece) {
        const std::size_t first = static_cast<std::size_t>(piece) * kPiece;
        for (std::size_t i = first; i < std::min(count, first + kPiece); ++i) work(i);
    });
}

void dim(float& r, float& g, float& b, float light) {
    r *= light;
    g *= light;
    b *= light;
}

// Dims the opaque layers of both headers, which start as copies of the camera's.
void shadow_opaque(const ShadowCaster& caster, TraceHeader& shadowed, TraceHeader& exact, int threads,
                   ShadowLookups& lookups) {
    if (!shadowed.opaque) return;
    const auto samples = static_cast<std::size_t>(shadowed.samples);
    const auto width = static_cast<std::size_t>(shadowed.width);
    const std::vector<float>& depth = shadowed.opaque->depth;
    const auto positions = sample_positions(shadowed.samples);
    std::vector<Seen> seen;
    for (std::size_t first = 0; first < depth.size(); first += kBand) {
        seen.assign(std::min(kBand, depth.size() - first), Seen{});
        for_each_in_parallel(threads, seen.size(), [&](std::size_t i) {
            const std::size_t at = first + i;
            if (!std::isfinite(depth[at])) return;
            const SamplePosition position = positions[at % samples];
            const std::size_t row = at / samples / width;
            const std::size_t column = at / samples % width;
            const ViewPoint point{static_cast<double>(column) + 0.5 + static_cast<double>(position.x()),
                                  static_cast<double>(row) + 0.5 + static_cast<double>(position.y()),
                                  static_cast<double>(depth[at])};
            seen[i] = caster.look_up(point, mix64(caster.seed() ^ ~std::uint64_t{at}), true);
            for (const auto& [layer, visibility] :
                 {std::pair(&shadowed.opaque->rgb, seen[i].estimate), {&exact.opaque->rgb, seen[i].exact}})
                dim((*layer)[3 * at], (*layer)[3 * at + 1], (*layer)[3 * at + 2], caster.light(visibility));
        });
        caster.count(seen, lookups);
    }
}

}  // namespace

void VisibilityError::add(double estimate, double exact) {
    const double error = estimate - exact;
    ++count;
    sum += error;
    sum_of_squares += error * error;
    max = std::max(max, std::abs(error));
}

double VisibilityError::rmse() const {
    return count == 0 ? 0 : std::sqrt(sum_of_squares / static_cast<double>(count));
}

ShadowedTrace cast_shadows(TraceReader& camera, const TraceHeader& light, const StoredShadowMap& map,
                           const DeepShadowMap& deep, const ShadowReceiving& receiving,
                           const std::string& shadowed, const std::string& exact) {
    ShadowedTrace result;
    const TraceHeader& header = camera.header();
    const ShadowCaster caster(header, light, map, deep, receiving);
    TraceHeader shadowed_header = header;
    shadowed_header.non_finite = false;
    TraceHeader exact_header = shadowed_header;
    shadow_opaque(caster, shadowed_header, exact_header, receiving.threads, result.opaque);
    TraceWriter shadowed_writer(shadowed, std::move(shadowed_header));
    TraceWriter exact_writer(exact, std::move(exact_header));
    const OpaqueDepthTest test(header);
    FragmentChunk chunk;
    FragmentChunk exact_chunk;
    std::vector<Seen> seen;
    camera.rewind();
    while (camera.next(chunk)) {
        exact_chunk = chunk;
        seen.assign(chunk.size(), Seen{});
        for_each_in_parallel(receiving.threads, chunk.size(), [&](std::size_t i) {
            Fragment& f = chunk.fragments[i];
            if (test.visible_samples(f, chunk.slopes.empty() ? DepthSlope{} : chunk.slopes[i]) == 0) return;
            const std::uint64_t pixel =
                static_cast<std::uint64_t>(f.y) * static_cast<std::uint64_t>(header.width) + f.x;
            const std::uint64_t key =
                mix64(mix64(caster.seed() + f.draw) ^ (pixel << 32) ^ primitive_number(f));
            seen[i] = caster.look_up({f.x + 0.5, f.y + 0.5, static_cast<double>(f.z)}, key, false);
            dim(f.r, f.g, f.b, caster.light(seen[i].estimate));
            Fragment& e = exact_chunk.fragments[i];
            dim(e.r, e.g, e.b, caster.light(seen[i].exact));
        });
        caster.count(seen, result.fragments);
        shadowed_writer.append(chunk);
        exact_writer.append(exact_chunk);
    }
    camera.rewind();
    shadowed_writer.finish();
    exact_writer.finish();
    return result;
}

}  // namespace ropsim
