// Adaptive transparency: Salvi, Montgomery and Lefohn 2011. The visibility function of a pixel is kept as at
// most N steps (sections 3.1 to 3.3) and composited with (equation 2). memory=fixed is the framebuffer
// operation of section 4 in two passes, memory=shader the same as a pixel shader under an interlock does it,
// memory=variable the prototype of section 4.1: per-pixel lists, the function made and used at resolve.
// Left open by the paper and decided here:
// - A fragment at a node's own depth is inserted in front of it, and depths are compared as nodes keep them;
//   equal_depth has other rules (rop/nodes/curve_rules.h).
// - Underestimation may remove every node but the first: the zeroth, implicit one has no transmittance to
//   lower. Overestimation may remove every node; the last one's area ends at the far plane.
// - Over traces of M > 1 spatial samples in fixed memory (section 5.4: one function a pixel, total
//   transmittance and colour a sample) a fragment enters the function with alpha times its share of the
//   samples; each sample's alpha channel multiplies up its exact total transmittance.
// - Variable memory makes a function for each sample of the fragments that cover it (section 4.2), from the
//   lists in their order, the latest arrival first. One pair of walks serves all samples, where shading at
//   sample rate would walk M times.
// composite=normalised is not in the paper: it scales a pixel's colour so that its weights sum to total
// alpha.
#include "rop/accumulated_color.h"
#include "rop/nodes/curve_resolve.h"
#include "rop/nodes/stored_curve.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace ropsim {

class Adaptive {
 public:
    static constexpr TechniqueInfo kInfo = {
        "adaptive", "adaptive transparency (Salvi et al. 2011)",
        "nodes=8 (2..64), memory=fixed|shader|variable, removal=underestimate|overestimate|node_by_node, "
        "candidates=paper|protect_furthest|protect_front_half, equal_depth=in_front|behind|merge, "
        "composite=plain|normalised, transmittance_rounding=nearest|down|dithered, "
        "layout=interleaved|planar",
        true, "nodes=8"};

    Adaptive(Parameters& parameters, const Screen& screen)
        : rules_(CurveRules::read(parameters,
                                  static_cast<int>(parameters.get_integer("nodes", 8, 2, kMaxNodes)))),
          normalised_(parameters.get_choice("composite", "plain", {"plain", "normalised"}) == "normalised"),
          samples_(screen.samples) {
        const TechniqueFormats formats(parameters);
        const std::string memory = parameters.get_choice("memory", "fixed", {"fixed", "shader", "variable"});
        variable_ = memory == "variable";
        if (variable_) {
            lists_ = FragmentLists(declaration_, formats, samples_);
            declaration_.passes = {{"append", Shading::kFull}};
            declaration_.paths = {"append", "overflow", "resolve"};
        } else {
            declare_fixed(parameters, formats, memory == "shader");
        }
        declaration_.ordering = Ordering::kRaster;
        // A node of transmittance 1 in front of all others is never removed and leaves one node less for the
        // rest.
        declaration_.zero_alpha_harmless = false;
        declaration_.uses_coverage = true;
        declaration_.image_format = formats.image();
        declaration_.light = normalised_ ? LightLaw::kScaled : LightLaw::kConserved;
    }
    const Declaration& declaration() const { return declaration_; }
    bool draws(int pass) const { return declaration_.random && pass == 0; }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        if constexpr (!D::kCharged) {
            if (is_paper_) [[likely]] {
                curve_.fetch(pixel);
                const PixelNodes nodes = curve_.nodes(pixel);
                if (pass == 0)
                    return insert_in_place(nodes, rules_, f.z, 1.0f - f.a) ? kInsertCompress : kInsert;
                pixel.fetch_all(color_, 1);
                accumulate_rgb<D>(pixel, color_, transmittance_in_front(nodes, rules_.nodes, f.z),
                                  f.premultiplied);
                return kComposite;
            }
            // Of copies, so that nothing of the operation above has to be in memory.
            D own_d = d;
            P own_pixel = pixel;
            const FragmentInput<D> own_f = f;
            const int path = any_fragment(own_d, pass, own_f, own_pixel);
            d = own_d;
            return path;
        } else {
            return any_fragment(d, pass, f, pixel);
        }
    }

    template <class D, class P>
    Rgb<D> resolve(D& d, const Background<D>& background, P& pixel, int& path) const {
        if (variable_) {
            path = kListResolve;
            return from_lists().resolve(d, background, pixel);
        }
        path = kResolve;
        if (samples_ == 1) curve_.fetch_total(pixel);
        pixel.fetch_all(color_, samples_);
        std::array<Rgb<D>, kMaxSpatialSamples> colors;
        for (int m = 0; m < samples_; ++m) {
            CurveSums<D> sums;
            sums.total = samples_ == 1 ? curve_.total(pixel) : pixel.load(total_, m);
            sums.color = pixel.load_rgb(color_, m);
            if (normalised_) sums.weight = pixel.load(weight_, m);
            const auto k = static_cast<std::size_t>(m);
            colors[k] =
                over_background(sums, normalised_, samples_ == 1 ? background.mean : background.sample[k]);
        }
        return mean_of_samples<D>(colors, samples_);
    }

    // For a fragment that is alone at its depth; where equal_depth=merge, of a node's depth, the mean of both
    // sides.
    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        const int curves = variable_ ? samples_ : 1;
        std::ranges::fill(values, 0.0f);
        for (int m = 0; m < curves; ++m) {
            const Curve<PlainDatapath> curve =
                variable_ ? from_lists().curve(pixel, m) : curve_.loaded<PlainDatapath>(pixel);
            for (std::size_t i = 0; i < depths.size(); ++i)
                values[i] += visibility_of<PlainDatapath>(curve, rules_,
                                                          rules_.kept_depth<PlainDatapath>(depths[i]), 1.0f) /
                             static_cast<float>(curves);
        }
    }

 private:
    enum Path { kInsert, kInsertCompress, kComposite, kResolve, kMergeNode };
    enum ListPath { kAppend, kOverflow, kListResolve };

    void declare_fixed(Parameters& parameters, const TechniqueFormats& formats, bool rewrites) {
        rules_.read_formats(parameters, formats);
        const Layout layout =
            parameters.get_choice("layout", "interleaved", {"interleaved", "planar"}) == "planar"
                ? Layout::kPlanar
                : Layout::kInterleaved;
        curve_ = StoredCurve(declaration_, rules_, layout, rewrites);
        is_paper_ = curve_.is_paper() && samples_ == 1 && !normalised_;
        declare_color(formats, layout);
        declaration_.passes = {{"visibility", Shading::kAlphaOnly}, {"composite", Shading::kFull}};
        declaration_.paths = {"insert", "insert_compress", "composite", "resolve"};
        if (rules_.coplanar == CoplanarRule::kMerge) declaration_.paths.emplace_back("merge");
        declaration_.random = rules_.rounding == NodeRounding::kDithered;
    }
    // Four channels a sample. The fourth holds the sample's total transmittance where there are several, else
    // the sum of weights if anything reads it; with both, the weights are a channel of their own.
    void declare_color(const TechniqueFormats& formats, Layout layout) {
        const bool many = samples_ > 1;
        if (!many && !normalised_) {
            color_ = declaration_.surface(
                "accumulated_color", 1, layout, Initial::kClear,
                {FieldSpec::real(formats.rgb("color", Format::kFloat16), 4, 0.0f, ValueRange::kSum)})[0];
            return;
        }
        const Format format = formats.of("color", Format::kFloat16);
        std::vector<FieldSpec> fields = {FieldSpec::real(format, 3, 0.0f, ValueRange::kSum)};
        if (many) fields.push_back(FieldSpec::real(format, 1, 1.0f, ValueRange::kUnit));
        if (normalised_) fields.push_back(FieldSpec::real(format, 1, 0.0f, ValueRange::kSum));
        const auto handles =
            declaration_.surface("accumulated_color", samples_, layout, Initial::kClear, fields);
        color_ = handles[0];
        if (many) total_ = handles[1];
        if (normalised_) weight_ = handles.back();
    }
    CurvesFromLists from_lists() const { return {rules_, lists_, samples_, normalised_}; }

    // The fragment's transmittance as it enters the pixel's curve.
    template <class D>
    typename D::Real transmittance_of(const FragmentInput<D>& f) const {
        using Real = typename D::Real;
        if (samples_ == 1) return Real(1.0f) - f.a;
        return Real(1.0f) - f.a * share<D>(population_count(f.coverage));
    }
    // Of the samples, of which there are a power of two: an integer to float, its exponent lowered.
    template <class D>
    typename D::Real share(const typename D::Uint& covered) const {
        const float value = static_cast<float>(value_of(covered)) / static_cast<float>(samples_);
        if constexpr (D::kCharged)
            return {value, Ledger::active().charge(Unit::kConverter, covered.ready)};
        else
            return value;
    }

    // Apart, so that the paper's own operation is compiled without it.
    template <class D, class P>
    [[gnu::noinline]] int any_fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        if (variable_) return lists_.append(d, f, pixel) ? kAppend : kOverflow;
        curve_.fetch(pixel);
        if (pass == 0) return build(d, f, pixel);
        return samples_ == 1 ? composite<D>(f, pixel) : composite_samples<D>(f, pixel);
    }

    template <class D, class P>
    int build(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        const Real draw = declaration_.random ? draw_unit<D>(f.key, 0) : Real(0.0f);
        switch (curve_.insert(d, f.z, transmittance_of<D>(f), draw, pixel)) {
            case CurveInsertion::kInserted:
                return kInsert;
            case CurveInsertion::kCompressed:
                return kInsertCompress;
            default:
                return kMergeNode;
        }
    }

    template <class D, class P>
    typename D::Real visibility_in(const FragmentInput<D>& f, P& pixel) const {
        const bool own = rules_.coplanar != CoplanarRule::kInFront;
        return curve_.visibility<D>(f.z, own ? transmittance_of<D>(f) : typename D::Real(1.0f), pixel);
    }
    template <class D, class P>
    int composite(const FragmentInput<D>& f, P& pixel) const {
        pixel.fetch_all(color_, 1);
        const typename D::Real visibility = visibility_in<D>(f, pixel);
        if (normalised_) pixel.put(weight_, 0, 0, saturated(weight_, pixel.load(weight_) + visibility * f.a));
        accumulate_rgb<D>(pixel, color_, visibility, f.premultiplied);
        return kComposite;
    }
    // Each sample that the fragment covers.
    template <class D, class P>
    int composite_samples(const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        for (int m = 0; m < samples_; ++m) pixel.fetch_if(bit(f.coverage, m), color_, m);
        const Real visibility = visibility_in<D>(f, pixel);
        const Rgb<D> seen = {visibility * f.premultiplied.r, visibility * f.premultiplied.g,
                             visibility * f.premultiplied.b};
        const Real t = Real(1.0f) - f.a;
        const Real weight = normalised_ ? visibility * f.a : Real(0.0f);
        for (int m = 0; m < samples_; ++m) {
            const auto covered = bit(f.coverage, m);
            const Rgb<D> sum = pixel.load_rgb(color_, m);
            pixel.write_if(covered, color_, m);
            pixel.put_rgb_if(covered, color_, m,
                             saturated(color_, Rgb<D>{sum.r + seen.r, sum.g + seen.g, sum.b + seen.b}));
            pixel.put_if(covered, total_, m, 0, pixel.load(total_, m) * t);
            if (normalised_)
                pixel.put_if(covered, weight_, m, 0, saturated(weight_, pixel.load(weight_, m) + weight));
        }
        return kComposite;
    }

    CurveRules rules_;
    bool normalised_;
    int samples_;            // M
    bool variable_ = false;  // memory=variable
    bool is_paper_ = false;  // fixed memory with nothing beyond the paper
    Declaration declaration_;
    FragmentLists lists_;
    StoredCurve curve_;
    Field color_;
    Field total_;
    Field weight_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(adaptive, Adaptive)
