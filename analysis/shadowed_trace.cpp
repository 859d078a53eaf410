#include "analysis/shadowed_trace.h"

#include "analysis/shadow_traversal.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ropsim {

namespace {

class ShadowCaster {
 public:
    struct Seen {
        bool looked_up = false;
        bool inside = false;
        double estimate = 1;
        double exact = 1;                  // through the filter
        double exact_texel = 1;            // of the point's own texel
        std::uint32_t texels = 0;          // read, inside the map
        std::uint32_t sampled_texels = 0;  // of which the samples were read
    };

    ShadowCaster(const TraceHeader& camera, const TraceHeader& light, const StoredShadowMap& map,
                 const DeepShadowMap& deep, const ShadowReceiving& receiving, ShadowedTrace& result)
        : to_light_(camera, light), map_(map), deep_(deep), receiving_(receiving), result_(result) {
        texel_filter_.bias = receiving.filter.bias;
        texel_filter_.slope_bias = receiving.filter.slope_bias;
        texel_filter_.side = 1;
    }

    Seen look_up(const ViewPoint& point, std::uint64_t key, const ShadowReceiver& receiver) const {
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
                if (map_.corrected() && receiver.opaque) {
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
    void count(const std::vector<Seen>& all, bool opaque) {
        ShadowLookups& to = opaque ? result_.opaque : result_.fragments;
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

    glm::vec3 light(const Seen& seen) const { return glm::vec3(dimmed(seen.estimate)); }
    glm::vec3 exact_light(const Seen& seen) const { return glm::vec3(dimmed(seen.exact)); }
    std::uint64_t seed() const { return receiving_.seed * 0x9E3779B97F4A7C15ull; }
    int threads() const { return receiving_.threads; }

 private:
    float dimmed(double visibility) const {
        return static_cast<float>(receiving_.ambient + (1 - receiving_.ambient) * visibility);
    }

    LightSpace to_light_;
    const StoredShadowMap& map_;
    const DeepShadowMap& deep_;
    const ShadowReceiving& receiving_;
    ShadowedTrace& result_;
    ShadowFilter texel_filter_;
};

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
    ShadowCaster caster(camera.header(), light, map, deep, receiving, result);
    cast_shadows_on(camera, caster, shadowed, exact);
    return result;
}

}  // namespace ropsim
