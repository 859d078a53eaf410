// Phenomenological transparency: McGuire and Mara 2017 (TVCG; I3D 2016), sections 4, 5 and 7 and the
// appendix. Three render targets under fixed-function blending (Table 2): A sums weighted colour and net
// coverage, beta multiplies what each channel of the background is left with, D^2 and delta sum how far the
// background is blurred and displaced. What a fragment exports is its shader's work
// (rop/phenomenological/surface_shader.h); the operation is the blend alone. Resolve displaces and blurs the
// opaque layer and lays the normalised A over it.
//
// Where the paper says two things both can be had, and the default is what its own equations imply: beta of
// equation 2, not a third of it (Listing 1); D weighted by alpha (equations 6 and 7), not by net coverage
// (Listing 1: clear frosted glass would not scatter), as a sum of variances (equation 7); Snell's law for
// equation 9, which as printed bends rays at eta = 1; k1 of .5 m (the listing: .05); both codes of 1/63
// (Table 2) read back as 63 pixels, not 200 and .375 of the screen (Listing 3); what passes all light is
// resolved too (Listing 3 returns where beta is 1); beta's floor in self-modulation (Listing 3), without
// which equation 14 halves what opaque surfaces reflect. k0, which the paper does not give, is .128 m: the
// listing's 120 pixels at 1920x1080 and a vertical field of view of 60 degrees.
//
// Displacements are weighted by net coverage and added, as the listing does and the text says: glass that
// passes nine tenths bends a tenth of what Snell's law gives, and clear glass nothing.
// refraction_weight=alpha is "exact for a single surface", which the text says too. A surface's back bends
// like its front.
//
// Where A_a has overflowed the largest colour takes its place, where a colour has, white (Listing 3). Traces
// of one spatial sample only.
#include "rop/phenomenological/aggregate_layers.h"
#include "rop/phenomenological/background_filter.h"
#include "rop/phenomenological/framebuffer_targets.h"
#include "rop/phenomenological/upsampling.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"
#include "traces/least_alpha.h"

#include <algorithm>
#include <limits>

namespace ropsim {

class Phenomenological {
 public:
    static constexpr TechniqueInfo kInfo = {
        "phenomenological",
        "phenomenological transparency: colour, refraction, diffusion (McGuire and Mara 2017)",
        "form=full|alpha, weight=eq5|listing|g3d|eq7|eq8|eq9|eq10|blog2015|learnopengl|none, "
        "beta=product|third, "
        "refraction=snell|printed|off, refraction_depth=2 (metres), refraction_weight=net|alpha, "
        "diffusion=on|off, "
        "diffusion_weight=alpha|net, diffusion_sum=variance|deviation, background=finite|infinite, k0=0.128, "
        "k1=0.5 (metres), self_modulation=on|off, filter=disk|gaussian, gather=strided|exact, max_radius=16 "
        "(0..63), decoding=table|listing, early_out=all|beta, underflow=raise|round, "
        "overflow=replace|saturate, "
        "separate_alpha=on|off, offsets=signed|biased|split, low_resolution=1|2|4, "
        "low_draws=NAME[+NAME]|all, "
        "upsample=tent7|bilinear, aggregate_draws=NAME[+NAME]|all, aggregate_layers=4 (1..16), "
        "register_draws=NAME[+NAME]|all",
        true, ""};

    Phenomenological(Parameters& parameters, const Screen& screen)
        : options_(parameters, screen), shader_(options_, parameters, screen), filter_(options_, screen) {
        const TechniqueFormats formats(parameters);
        const TargetFormats stored(formats);
        if (!stored.fits(options_))
            throw UserError(parameters.where("delta_format"),
                            "has no negative numbers; use float16, float32, or offsets=split");
        targets_ = {declaration_, stored, options_, "", 1};
        declare_gathers();
        if (options_.low_scale > 1) {
            low_ = {declaration_, stored, options_, "low_", options_.low_scale};
            upsampling_ = {declaration_, options_, parameters, screen};
            for (Surface& s : declaration_.surfaces)
                if (s.scale > 1) s.gathered = upsampling_.taps();
        }
        if (options_.aggregate_draws.given)
            aggregate_ = {declaration_, formats, options_.aggregate_layers, options_.low_scale};
        declare_passes(screen.draws.size());
        declare_resolve();
        declaration_.ordering = Ordering::kAny;
        declaration_.zero_alpha_harmless = !options_.aggregate_draws.given;  // it takes a layer
        declaration_.image_format = formats.image();
        declaration_.shades_materials = screen.materials && (options_.refracts || !options_.alpha_only);
        declaration_.knows_alpha_alone = options_.alpha_only;
        declaration_.colored_transmission = screen.materials && !options_.alpha_only;
        declaration_.light = shader_.light_law(stored.accumulated, declaration_.colored_transmission);
        declaration_.added_shading = shader_.added_shading();
        if (options_.register_draws.given) declaration_.joined_draws = options_.register_draws.chosen;
    }
    const Declaration& declaration() const { return declaration_; }

    Exports shade(int pass, const ShadedFragment& f) const {
        if (pass != passes_.layers) return shader_.shade(f);
        // A layer knows alpha alone: with form=alpha the trace has given the least that means the same.
        Exports out{};
        out[kLayerAlpha] = options_.alpha_only ? f.fragment.a : least_alpha(f.fragment.a, f.material);
        return out;
    }
    Exports joined(const Exports& first, const Exports& second) const {
        return shader_.joined(first, second);
    }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        if (pass == passes_.layers)
            return paths_.append + aggregate_.insert<D>(d, f, f.exported[kLayerAlpha], pixel);
        const bool low = pass == passes_.low;
        const FramebufferTargets& targets = low ? low_ : targets_;
        targets.fetch_accumulated(pixel);
        targets.fetch_rest(pixel);
        const auto& e = f.exported;
        constexpr std::size_t kAbsorbed = surface_export::kAbsorbed;
        targets.template blend<D>(
            pixel, e,
            {Real(1.0f) - e[kAbsorbed], Real(1.0f) - e[kAbsorbed + 1], Real(1.0f) - e[kAbsorbed + 2]},
            shader_);
        return low ? paths_.low : paths_.blend;
    }

    // Aggregated layers become a surface where they were drawn.
    template <class D, class P>
    int image_pass(D&, int, P& pixel) const {
        aggregate_.blend<D>(pixel, options_.low_scale > 1 ? low_ : targets_, shader_);
        return paths_.aggregate;
    }

    template <class D, class P>
    int gather_pass(D& d, int, Gather<P>& gather) const {
        P& pixel = gather.own();
        targets_.fetch_accumulated(pixel);
        targets_.fetch_rest(pixel);
        const auto sum = upsampling_.upsampled<D>(d, gather, low_);
        targets_.blend<D>(pixel, sum.exports, sum.beta, shader_);
        return paths_.upsample;
    }

    template <class D, class P>
    Rgb<D> resolve_gather(D& d, Gather<P>& gather, int& path) const {
        using Real = typename D::Real;
        P& own = gather.own();
        targets_.fetch_rest(own);
        const Rgb<D> beta = targets_.beta(own);
        const Real stored = options_.diffuses ? targets_.diffusion(own) : Real(0.0f);
        const auto code =
            options_.refracts ? targets_.offset(own) : FramebufferTargets::Offset<D>{Real(0.0f), Real(0.0f)};
        const auto absorbs = minimum(minimum(beta.r, beta.g), beta.b) < Real(1.0f);
        const auto blurs = Real(0.0f) < stored;
        const auto moves = Real(0.0f) < maximum(magnitude(code.x), magnitude(code.y));
        const auto seen = options_.listing_early_out ? absorbs : either(absorbs, either(blurs, moves));
        if (!d.decide(seen)) {
            path = paths_.nothing;
            return gather.background(gather.x(), gather.y());
        }
        own.next_fetch_stage(seen);
        gather.next_fetch_stage(seen);
        targets_.fetch_accumulated(own);
        const Rgb<D> surface = over_all<D>(own, beta);
        const Rgb<D> behind = background<D>(d, gather, stored, blurs, code, moves, path);
        return {behind.r * beta.r + surface.r, behind.g * beta.g + surface.g, behind.b * beta.b + surface.b};
    }

 private:
    static constexpr std::size_t kLayerAlpha = 0;  // export of the layers' pass

    void declare_passes(std::size_t draws) {
        const bool chooses = options_.low_draws.given || options_.aggregate_draws.given;
        const auto add = [&](Pass pass) {
            declaration_.passes.push_back(std::move(pass));
            return static_cast<int>(declaration_.passes.size()) - 1;
        };
        const auto path = [&](const char* name) {
            declaration_.paths.emplace_back(name);
            return static_cast<int>(declaration_.paths.size()) - 1;
        };
        Pass geometry;
        geometry.scale = options_.low_scale;
        if (options_.low_draws.given) {
            geometry.name = "low_resolution";
            geometry.draws = options_.low_draws.chosen;
            passes_.low = add(geometry);
            paths_.low = path("blend_low");
        }
        if (options_.aggregate_draws.given) {
            geometry.name = "layers";
            geometry.draws = options_.aggregate_draws.chosen;
            passes_.layers = add(geometry);
            paths_.append = path("append");
            path("replace");
            path("dropped");
            add({.name = "aggregate", .kind = PassKind::kImage, .scale = options_.low_scale});
            paths_.aggregate = path("aggregate");
        }
        Pass accumulate{.name = "accumulate"};
        for (std::size_t d = 0; chooses && d < std::max<std::size_t>(draws, 1); ++d)
            accumulate.draws.push_back(options_.low_draws[d] || options_.aggregate_draws[d] ? 0 : 1);
        add(accumulate);
        paths_.blend = path("blend");
        if (options_.low_scale > 1) {
            add({.name = "upsample", .kind = PassKind::kImage, .gathers = true});
            paths_.upsample = path("upsample");
        }
    }
    void declare_resolve() {
        const auto path = [&](const char* name) {
            declaration_.paths.emplace_back(name);
            return static_cast<int>(declaration_.paths.size()) - 1;
        };
        paths_.nothing = path("resolve_nothing");
        paths_.plain = path("resolve");
        if (options_.refracts) paths_.refract = path("resolve_refract");
        if (options_.diffuses) paths_.diffuse = path("resolve_diffuse");
    }
    void declare_gathers() {
        declaration_.gathers = true;
        declaration_.resolve_reads_background = false;
        const int taps = options_.diffuses ? filter_.most_taps() : 0;
        declaration_.background_gathered = std::max(taps, options_.refracts ? 4 : 1);
        for (Surface& s : declaration_.surfaces)
            if (s.name == (options_.separate_alpha ? "beta" : "delta")) s.gathered = taps;
    }

    template <class D, class P>
    Rgb<D> background(D& d, Gather<P>& gather, const typename D::Real& stored, const typename D::Bool& blurs,
                      const FramebufferTargets::Offset<D>& code, const typename D::Bool& moves,
                      int& path) const {
        if (options_.diffuses && d.decide(blurs)) {
            path = paths_.diffuse;
            const auto variance = filter_.variance(stored);
            const auto offset = filter_.pixels<D>(code);
            return filter_.diffused<D>(d, gather, targets_, value_of(variance), value_of(offset.x),
                                       value_of(offset.y));
        }
        if (options_.refracts && d.decide(moves)) {
            path = paths_.refract;
            return BackgroundFilter::displaced<D>(gather, filter_.pixels<D>(code));
        }
        path = paths_.plain;
        return gather.background(gather.x(), gather.y());
    }

    // The surfaces' colour, normalised, under its share of the pixel: equations 3 and 14.
    template <class D, class P>
    Rgb<D> over_all(P& own, const Rgb<D>& beta) const {
        using Real = typename D::Real;
        const Rgb<D> sum = targets_.color(own);
        const Real weights = targets_.net(own);
        const Real largest = maximum(maximum(sum.r, sum.g), sum.b);
        const Real mended = select(is_finite(weights), weights, largest);
        const auto overflown = inverse(both(both(is_finite(sum.r), is_finite(sum.g)), is_finite(sum.b)));
        const Real scale = Real(1.0f) / maximum(mended, Real(1e-5f));
        const Real brightest = maximum(maximum(beta.r, beta.g), beta.b);
        const Real hue = Real(1.0f) / maximum(Real(2e-3f), brightest + brightest);
        const auto channel = [&](const Real& color, const Real& b) {
            Real mean = select(overflown, Real(1.0f), color * scale);
            if (options_.self_modulates) mean = mean * (Real(0.5f) + maximum(b, Real(1e-3f)) * hue);
            return (Real(1.0f) - b) * mean;
        };
        return {channel(sum.r, beta.r), channel(sum.g, beta.g), channel(sum.b, beta.b)};
    }
    template <class R>
    static auto is_finite(const R& value) -> decltype(value < value) {
        return magnitude(value) <= R(std::numeric_limits<float>::max());
    }

    PhenomenologicalOptions options_;
    SurfaceShader shader_;
    BackgroundFilter filter_;
    Declaration declaration_;
    FramebufferTargets targets_;
    FramebufferTargets low_;
    Upsampling upsampling_;
    AggregateLayers aggregate_;
    struct Passes {
        int low = -1, layers = -1;
    } passes_;
    struct Paths {
        int low = -1, append = -1, aggregate = -1, blend = -1, upsample = -1;
        int nothing = -1, plain = -1, refract = -1, diffuse = -1;
    } paths_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(phenomenological, Phenomenological)
