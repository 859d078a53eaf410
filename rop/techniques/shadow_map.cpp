// Stochastic shadow maps: Enderton, Sintorn, Shirley and Luebke 2011, sections 3.2 and 3.6. The trace is a
// light's view. A fragment picks its samples as in `stochastic`, and the depth test keeps the nearest in
// each, depth alone: a look-up counts the samples that are not nearer (rop/shadow/). With total_alpha=on a
// pass of its own gathers each texel's total alpha for alpha-corrected look-ups, and the map holds
// transparent fragments only; the opaque layer's depths stay where the opaque pass left them.
#include "rop/sampling/mask_chooser.h"
#include "rop/technique_formats.h"

namespace ropsim {

class ShadowMap {
 public:
    static constexpr TechniqueInfo kInfo = {
        "shadow_map", "stochastic shadow map of a light's view, depths and no colour (Enderton et al. 2011)",
        "samples=8 (1..64, a multiple of the trace's), total_alpha=off|on, "
        "masks=choose|coin|run|table|alpha_to_coverage|blue_noise, rounding=random|dither, "
        "depth_test=last|first, seed_from=primitive|depth|object|object_facing|pattern"};
    static constexpr bool kRandom = true;

    ShadowMap(Parameters& parameters, const Screen& screen)
        : options_(SamplingOptions::depth_alone(parameters, screen)), chooser_(parameters, screen, options_) {
        if (chooser_.samples_vary())
            throw UserError(
                parameters.where("bright_samples"),
                "goes by the colour behind a pixel, which a shadow map does not have; leave it out");
        const bool corrected = parameters.get_choice("total_alpha", "off", {"off", "on"}) == "on";
        const TechniqueFormats formats(parameters);
        depth_ = declaration_.surface(
            "depth", options_.samples, Layout::kPlanar, corrected ? Initial::kClear : Initial::kOpaqueDepth,
            {FieldSpec::real(formats.of("depth", Format::kFloat32), 1, 1.0f, ValueRange::kUnit)})[0];
        declaration_.passes = {{"stochastic_depth", Shading::kAlphaOnly}};
        declaration_.paths = {MaskChooser::kNothing, MaskChooser::kWrite};
        if (corrected) {
            const FieldSpec total =
                FieldSpec::real(formats.of("total_alpha", Format::kFloat16), 1, 1.0f, ValueRange::kUnit);
            total_ = declaration_.surface("total_alpha", 1, Layout::kPlanar, Initial::kClear, {total})[0];
            declaration_.passes.push_back({"total_alpha", Shading::kAlphaOnly});
            declaration_.paths.emplace_back("total_alpha");
        }
        MaskChooser::declare_order(declaration_);
        declaration_.uses_coverage = true;
        declaration_.random = true;
        declaration_.resolves = false;
        declaration_.image_is_color = false;
        declaration_.image_format = formats.image();
    }
    ShadowMap(const ShadowMap&) = delete;
    ShadowMap& operator=(const ShadowMap&) = delete;
    const Declaration& declaration() const { return declaration_; }
    std::uint32_t pixel_constant(int, int, glm::vec3 background) const {
        return chooser_.pixel_constant(background);
    }
    std::uint64_t random_key(const Fragment& f) const { return chooser_.random_key(f); }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        if (pass == kTotalAlphaPass) return gather_total<D>(f, pixel);
        const FragmentDepths<D> depths = stored_depths<D>(f, pixel, depth_);
        const std::uint64_t covered =
            stored_coverage(value_of(f.coverage), options_.spatial_samples, options_.samples);
        const SampleChoice<D> choice =
            chooser_.choose(d, ChoiceInput<D, P>{f, depths, covered, pixel, depth_, false});
        if (choice.nothing) return kNothing;
        for_samples(choice.write, options_.samples, [&](int s) {
            const auto taken = choice.write.test(s);
            pixel.write_if(taken, depth_, s);
            pixel.put_if(taken, depth_, s, 0, depths.of(s));
        });
        return kWrite;
    }

    // A map is read by look-ups, not shown.
    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P&, int& path) const {
        path = kNothing;
        return background.mean;
    }

 private:
    enum Path { kNothing, kWrite, kTotalAlpha };
    static constexpr int kTotalAlphaPass = 1;

    // The product of transmittances. A fragment that covers part of the texel counts as a thinner one.
    template <class D, class P>
    int gather_total(const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        Real alpha = f.a;
        if (options_.spatial_samples > 1) {
            const int samples = std::popcount(value_of(f.coverage) & ((1u << options_.spatial_samples) - 1u));
            alpha = alpha * Real(static_cast<float>(samples) / static_cast<float>(options_.spatial_samples));
        }
        pixel.fetch_all(total_, 1);
        pixel.write(total_);
        pixel.put(total_, 0, 0, pixel.load(total_) * (Real(1.0f) - alpha));
        return kTotalAlpha;
    }

    SamplingOptions options_;
    MaskChooser chooser_;
    Declaration declaration_;
    Field depth_;
    Field total_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(shadow_map, ShadowMap)
