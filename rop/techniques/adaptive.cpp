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
//   lists in their order, the latest arrival first.
// composite=normalised is not in the paper: it scales a pixel's colour so that its weights sum to total
// alpha.
#include "rop/accumulated_color.h"
#include "rop/nodes/curve_resolve.h"
#include "rop/nodes/insert_in_place.h"
#include "rop/nodes/vector_insertion.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
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
        rewrites_ = memory == "shader";
        if (variable_) {
            lists_ = FragmentLists(declaration_, formats, samples_);
            declaration_.passes = {{"append", Shading::kFull}};
            declaration_.paths = {"append", "overflow", "resolve"};
        } else {
            declare_fixed(parameters, formats);
        }
        declaration_.ordering = Ordering::kRaster;
        // A node of transmittance 1 in front of all others is never removed and leaves one node less for the
        // rest.
        declaration_.zero_alpha_harmless = false;
        declaration_.uses_coverage = true;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }
    bool draws(int pass) const { return declaration_.random && pass == 0; }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        if (variable_) return lists_.append(d, f, pixel) ? kAppend : kOverflow;
        pixel.fetch_all(depth_, rules_.nodes);
        if (pass == 0) return build(d, f, pixel);
        return samples_ == 1 ? composite<D>(f, pixel) : composite_samples<D>(f, pixel);
    }

    template <class D, class P>
    Rgb<D> resolve(D& d, const Background<D>& background, P& pixel, int& path) const {
        if (variable_) {
            path = kListResolve;
            return from_lists().resolve(d, background, pixel);
        }
        path = kResolve;
        // The transmittance of everything: the last node holds it even while nodes are empty, because
        // insertion multiplies every node behind the fragment, empty ones too.
        if (samples_ == 1) pixel.fetch_all(depth_, rules_.nodes);
        pixel.fetch_all(color_, samples_);
        std::array<Rgb<D>, kMaxSpatialSamples> colors;
        for (int m = 0; m < samples_; ++m) {
            CurveSums<D> sums;
            sums.total = samples_ == 1 ? pixel.load(transmittance_, rules_.nodes - 1) : pixel.load(total_, m);
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
                variable_ ? from_lists().curve(pixel, m)
                          : Curve<PlainDatapath>::loaded(pixel, depth_, transmittance_, rules_.nodes);
            for (std::size_t i = 0; i < depths.size(); ++i)
                values[i] += visibility_of<PlainDatapath>(curve, rules_,
                                                          rules_.kept_depth<PlainDatapath>(depths[i]), 1.0f) /
                             static_cast<float>(curves);
        }
    }

 private:
    enum Path { kInsert, kInsertCompress, kComposite, kResolve, kMergeNode };
    enum ListPath { kAppend, kOverflow, kListResolve };

    void declare_fixed(Parameters& parameters, const TechniqueFormats& formats) {
        rules_.read_formats(parameters, formats);
        short_cut_ = rules_.is_plain();
        by_fours_ = short_cut_ && rules_.first_underestimated == 1 && rules_.last_removable == rules_.nodes &&
                    inserts_four_at_a_time(rules_.nodes);
        const Layout layout =
            parameters.get_choice("layout", "interleaved", {"interleaved", "planar"}) == "planar"
                ? Layout::kPlanar
                : Layout::kInterleaved;
        const auto node = declaration_.surface(
            "nodes", rules_.nodes, layout, Initial::kClear,
            {FieldSpec::real(rules_.depth, 1, kEmptyDepth), FieldSpec::real(rules_.transmittance, 1, 1.0f)});
        depth_ = node[0];
        transmittance_ = node[1];
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
            color_ =
                declaration_.surface("accumulated_color", 1, layout, Initial::kClear,
                                     {FieldSpec::real(formats.rgb("color", Format::kFloat16), 4, 0.0f)})[0];
            return;
        }
        const Format format = formats.of("color", Format::kFloat16);
        std::vector<FieldSpec> fields = {FieldSpec::real(format, 3, 0.0f)};
        if (many) fields.push_back(FieldSpec::real(format, 1, 1.0f));
        if (normalised_) fields.push_back(FieldSpec::real(format, 1, 0.0f));
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

    template <class D, class P>
    int build(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        if constexpr (!D::kCharged) {
            if (by_fours_) {
                const VectorInsertion done = insert_four_at_a_time(
                    rules_.nodes, pixel.element_words(depth_, 0), pixel.element_words(transmittance_, 0), f.z,
                    transmittance_of<D>(f), rules_.empty_depth);
                pixel.write_from(depth_, rewrites_ ? 0 : done.first_changed, rules_.nodes);
                return done.compressed ? kInsertCompress : kInsert;
            }
            if (short_cut_) {
                const bool full = insert_in_place(PixelNodes{pixel, depth_, transmittance_}, rules_, f.z,
                                                  transmittance_of<D>(f));
                if (rewrites_) [[unlikely]]
                    write_all(pixel);
                return full ? kInsertCompress : kInsert;
            }
        }
        const Real draw = declaration_.random ? draw_unit<D>(f.key, 0) : Real(0.0f);
        const auto old = Curve<D>::loaded(pixel, depth_, transmittance_, rules_.nodes);
        const Insertion<D> in =
            inserted<D>(old, rules_, rules_.template kept_depth<D>(f.z), transmittance_of<D>(f), draw);
        if (rewrites_) write_all(pixel);
        if (rules_.coplanar == CoplanarRule::kMerge && d.decide(in.coplanar)) {
            for (int i = 0; i < rules_.nodes; ++i) {
                const auto k = static_cast<std::size_t>(i);
                put_node(pixel, inverse(in.nearer[k]), i, old.depth[k],
                         select(in.nearer[k], old.transmittance[k], in.product[k]));
            }
            return kMergeNode;
        }
        // Full when the last of the N + 1 nodes is a real one.
        const auto last = static_cast<std::size_t>(rules_.nodes);
        if (!d.decide(in.curve.depth[last] < Real(rules_.empty_depth))) {
            for (int i = 0; i < rules_.nodes; ++i) {
                const auto k = static_cast<std::size_t>(i);
                put_node(pixel, inverse(in.nearer[k]), i, in.curve.depth[k], in.curve.transmittance[k]);
            }
            return kInsert;
        }
        Compressed<D> node(in.curve, rules_, least_error<D>(in.curve, rules_));
        for (int i = 0; i < rules_.nodes; ++i) {
            node.next();
            const auto k = static_cast<std::size_t>(i);
            put_node(pixel, either(inverse(in.nearer[k]), node.moved), i, node.depth, node.transmittance);
        }
        return kInsertCompress;
    }
    template <class P>
    void write_all(P& pixel) const {
        for (int i = 0; i < rules_.nodes; ++i) pixel.write(depth_, i);
    }
    // Values that are already what their formats keep.
    template <class P, class B, class R>
    void put_node(P& pixel, const B& changed, int i, const R& z, const R& v) const {
        pixel.write_if(changed, depth_, i);
        pixel.put_bits(depth_, i, 0, std::bit_cast<std::uint32_t>(value_of(z)));
        pixel.put_bits(transmittance_, i, 0, std::bit_cast<std::uint32_t>(value_of(v)));
    }

    template <class D, class P>
    typename D::Real visibility_in(const FragmentInput<D>& f, P& pixel) const {
        if constexpr (!D::kCharged) {
            if (by_fours_) {
                const int n = count_in_front(rules_.nodes, pixel.element_words(depth_, 0), f.z);
                return n == 0 ? 1.0f : pixel.load(transmittance_, n - 1);
            }
            if (short_cut_)
                return transmittance_in_front(PixelNodes{pixel, depth_, transmittance_}, rules_.nodes, f.z);
        }
        const auto curve = Curve<D>::loaded(pixel, depth_, transmittance_, rules_.nodes);
        using Real = typename D::Real;
        const Real t = rules_.coplanar == CoplanarRule::kInFront ? Real(1.0f) : transmittance_of<D>(f);
        return visibility_of<D>(curve, rules_, rules_.template kept_depth<D>(f.z), t);
    }
    template <class D, class P>
    int composite(const FragmentInput<D>& f, P& pixel) const {
        pixel.fetch_all(color_, 1);
        const typename D::Real visibility = visibility_in<D>(f, pixel);
        accumulate_rgb<D>(pixel, color_, visibility, f.premultiplied);
        if (normalised_) pixel.put(weight_, 0, 0, pixel.load(weight_) + visibility * f.a);
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
            pixel.put_rgb_if(covered, color_, m, {sum.r + seen.r, sum.g + seen.g, sum.b + seen.b});
            pixel.put_if(covered, total_, m, 0, pixel.load(total_, m) * t);
            if (normalised_) pixel.put_if(covered, weight_, m, 0, pixel.load(weight_, m) + weight);
        }
        return kComposite;
    }

    CurveRules rules_;
    bool normalised_;
    int samples_;             // M
    bool variable_ = false;   // memory=variable
    bool rewrites_ = false;   // memory=shader: every node is written back
    bool short_cut_ = false;  // insert_in_place will do
    bool by_fours_ = false;   // and four nodes at a time
    Declaration declaration_;
    FragmentLists lists_;
    Field depth_;
    Field transmittance_;
    Field color_;
    Field total_;
    Field weight_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(adaptive, Adaptive)
