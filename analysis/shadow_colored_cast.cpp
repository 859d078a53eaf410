#include "analysis/shadow_colored_cast.h"

#include "analysis/shadow_receiver_plane.h"
#include "analysis/shadow_traversal.h"

#include <limits>

namespace ropsim {

namespace {

class ColoredCaster {
 public:
    struct Seen {
        bool looked_up = false;
        bool inside = false;
        bool in_shadow = false;
        std::uint32_t texels = 0;  // read, a wavelength
        std::array<double, 3> estimate{1, 1, 1}, exact{1, 1, 1}, exact_texel{1, 1, 1}, transmittance{1, 1, 1},
            noiseless{1, 1, 1}, variance{};
    };

    ColoredCaster(const TraceHeader& camera, const TraceHeader& light, const ColoredShadow& shadow,
                  const ShadowReceiving& receiving, ColoredShadowedTrace& result)
        : to_light_(camera, light),
          planes_(camera, light),
          shadow_(shadow),
          receiving_(receiving),
          result_(result),
          maps_(shadow.run.wavelengths.size()),
          width_(light.width),
          height_(light.height),
          kernel_(shadow.filter.closer) {
        if (!shadow.filter.variance) return;
        // What the conversion replaces: percentage-closer filtering by the same tent.
        kernel_.shape = FilterShape::kTent;
        kernel_.side = shadow.filter.conversion.tent;
    }

    Seen look_up(const ViewPoint& point, std::uint64_t key, const ShadowReceiver& receiver) const {
        Seen seen;
        seen.looked_up = true;
        const ViewPoint at = to_light_(point);
        seen.inside = inside_view(at, width_, height_);
        if (!seen.inside) return seen;
        const int x = static_cast<int>(at.x);
        const int y = static_cast<int>(at.y);
        const auto texel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
        const double own_depth = asked_depth(kernel_, at, x, y);
        seen.in_shadow = static_cast<double>(shadow_.reference.opaque_depth(texel)) < own_depth;
        const ReceiverPlane plane =
            shadow_.filter.variance && !seen.in_shadow ? plane_of(receiver, point, at) : ReceiverPlane{};
        for (std::size_t w = 0; w < maps_; ++w) {
            if (seen.in_shadow) {
                seen.estimate[w] = seen.exact[w] = 0;
                continue;
            }
            const DeepShadowMap& deep = shadow_.reference.shadow[w];
            seen.exact_texel[w] = deep.visibility(
                x, y, shadow_.filter.variance ? plane.depth(at, x, y) - kernel_.bias : own_depth);
            look_up_exactly(seen, w, at, plane);
            look_up_stored(seen, w, at, key);
        }
        return seen;
    }

    glm::vec3 light(const Seen& seen) const { return dimmed(seen.estimate); }
    glm::vec3 exact_light(const Seen& seen) const { return dimmed(seen.exact); }
    std::uint64_t seed() const { return receiving_.seed * 0x9E3779B97F4A7C15ull; }
    int threads() const { return receiving_.threads; }

    void count(const std::vector<Seen>& all, bool opaque) {
        ColoredLookups& to = opaque ? result_.opaque : result_.fragments;
        for (const Seen& seen : all) {
            if (!seen.looked_up) continue;
            ++to.count;
            to.outside += seen.inside ? 0 : 1;
            to.in_shadow += seen.in_shadow ? 1 : 0;
            if (!seen.inside || seen.in_shadow) continue;
            to.texels += seen.texels;
            for (std::size_t w = 0; w < maps_; ++w) {
                WavelengthErrors& errors = to.wavelengths[w];
                errors.filter.add(seen.estimate[w], seen.exact[w]);
                errors.blur.add(seen.estimate[w], seen.exact_texel[w]);
                if (shadow_.filter.variance) errors.noise.add(seen.estimate[w], seen.noiseless[w]);
                if (!shadow_.reference.transmittance.empty())
                    errors.transmittance.add(seen.estimate[w], seen.transmittance[w]);
                errors.exact_sum += seen.exact[w];
                errors.expected_variance_sum += seen.variance[w];
            }
        }
    }

 private:
    ReceiverPlane plane_of(const ShadowReceiver& receiver, const ViewPoint& point,
                           const ViewPoint& at) const {
        if (receiver.opaque) return planes_.of_opaque(receiver.sample, point, at);
        return receiver.material != nullptr ? planes_.of_material(*receiver.material, at) : ReceiverPlane{};
    }

    // The exact map through the kernel, and the variance that S coins a texel have there. Percentage-closer
    // look-ups are held against the depths that they ask about themselves; a variance map's have one depth
    // for the whole kernel, and a kernel that is right asks where the receiver runs on.
    void look_up_exactly(Seen& seen, std::size_t w, const ViewPoint& at, const ReceiverPlane& plane) const {
        const DeepShadowMap& deep = shadow_.reference.shadow[w];
        const auto asked = [&](int x, int y, double by_slope_bias) {
            return shadow_.filter.variance ? plane.depth(at, x, y) - kernel_.bias : by_slope_bias;
        };
        double sum = 0;
        double variance = 0;
        const double weights = for_each_filtered(kernel_, at, [&](double weight, int x, int y, double z) {
            const bool inside = inside_map(x, y, width_, height_);
            const double visibility = inside ? deep.visibility(x, y, asked(x, y, z)) : 1.0;
            sum += weight * visibility;
            variance += weight * weight * visibility * (1 - visibility);
        });
        seen.exact[w] = sum / weights;
        seen.variance[w] = variance / (weights * weights * shadow_.run.colored.samples);
        if (shadow_.reference.transmittance.empty()) return;
        const DeepShadowMap& plain = shadow_.reference.transmittance[w];
        seen.transmittance[w] = whole_filter(kernel_, width_, height_, at, [&](int x, int y, double z) {
            return plain.visibility(x, y, asked(x, y, z));
        });
    }

    void look_up_stored(Seen& seen, std::size_t w, const ViewPoint& at, std::uint64_t key) const {
        if (shadow_.filter.variance) {
            const double z = at.z - kernel_.bias;
            seen.estimate[w] = shadow_.variance[w].visibility(at.x, at.y, z);
            seen.noiseless[w] = shadow_.expected[w].visibility(at.x, at.y, z);
            seen.texels = static_cast<std::uint32_t>(shadow_.variance[w].texels_a_fetch());
            return;
        }
        seen.texels = 0;
        seen.estimate[w] = filtered(kernel_, width_, height_, at, key, [&](int x, int y, double z) {
            ++seen.texels;
            return stochastic_visibility(shadow_.run.wavelengths[w], x, y, z);
        });
    }

    glm::vec3 dimmed(const std::array<double, 3>& visibility) const {
        glm::vec3 light(1.0f);
        for (int c = 0; c < 3; ++c)
            light[c] = static_cast<float>(receiving_.ambient +
                                          (1 - receiving_.ambient) *
                                              visibility[maps_ == 1 ? 0 : static_cast<std::size_t>(c)]);
        return light;
    }

    LightSpace to_light_;
    ReceiverPlanes planes_;
    const ColoredShadow& shadow_;
    const ShadowReceiving& receiving_;
    ColoredShadowedTrace& result_;
    std::size_t maps_;
    int width_, height_;
    ShadowFilter kernel_;
};

}  // namespace

ColoredReference::ColoredReference(TraceReader& light, const ColoredShadowOptions& options,
                                   bool opaque_blocks, int threads) {
    const TraceHeader& header = light.header();
    const LightDirections lights(header.camera, header.width, header.height);
    if (header.opaque) opaque = header.opaque->depth;
    ColoredShadowOptions plain = options;
    plain.caustics.on = false;
    for (std::size_t w = 0; w < static_cast<std::size_t>(options.wavelengths); ++w) {
        const auto taken = [&lights, w](const ColoredShadowOptions& by) {
            return [&lights, w, by](const Fragment& f, const Material& m) {
                return static_cast<double>(by.probability(f.a, m, lights.incidence(f, m), faces_back(f))[w]);
            };
        };
        shadow.emplace_back(light, taken(options), opaque_blocks, threads);
        if (options.caustics.on) transmittance.emplace_back(light, taken(plain), opaque_blocks, threads);
    }
}

float ColoredReference::opaque_depth(std::size_t texel) const {
    return opaque.empty() ? std::numeric_limits<float>::infinity() : opaque[texel];
}

ExpectedMoments expected_moments(const ColoredReference& reference, std::size_t wavelength,
                                 bool empty_is_opaque, int threads) {
    const DeepShadowMap& deep = reference.shadow[wavelength];
    ExpectedMoments expected;
    expected.moments = {deep.width(), deep.height(), {}};
    const auto texels = static_cast<std::size_t>(deep.width()) * static_cast<std::size_t>(deep.height());
    expected.moments.texels.resize(texels);
    expected.variance.resize(texels);
    parallel_for(threads, deep.height(), [&](int y) {
        for (int x = 0; x < deep.width(); ++x) {
            const std::size_t texel = expected.moments.texel(x, y);
            const double empty =
                empty_is_opaque ? std::min(1.0, static_cast<double>(reference.opaque_depth(texel))) : 1.0;
            const DeepShadowMap::DepthMean kept = deep.depth_kept(x, y, empty);
            expected.moments.texels[texel] = {static_cast<float>(kept.mean), static_cast<float>(kept.square)};
            expected.variance[texel] = kept.variance();
        }
    });
    return expected;
}

ColoredShadowedTrace cast_colored_shadows(TraceReader& camera, const TraceHeader& light,
                                          const ColoredShadow& shadow, const ShadowReceiving& receiving,
                                          const std::string& shadowed, const std::string& exact) {
    ColoredShadowedTrace result;
    ColoredCaster caster(camera.header(), light, shadow, receiving, result);
    cast_shadows_on(camera, caster, shadowed, exact);
    return result;
}

}  // namespace ropsim
