// Stochastic layered alpha blending: Wyman 2016, section 2.1. Continuous alphas or discrete coverage masks,
// equation 1 or the non-stratified one, and a colour straight from the layers or from a second geometry pass
// with the depth and alpha normalisation of Enderton et al. 2011, section 4.2.
// Left open by the paper and decided here:
// - Of equal depths the earlier arrival is nearer (the text is strict on both sides). The second pass looks
// up
//   what is strictly in front, so that a fragment does not hide itself.
// - Alphas become the nearest number of bits. A fragment of no bit is never inserted, and not fetched for.
// - bits=inf inserts always: the limit of equation 1 wherever the layers in front leave anything visible.
// - With masks the draw is the fragment's mask, and it is inserted if one of its bits is still uncovered:
// that
//   has the probability of equation 1 given both counts. Masks are those of `stochastic`: R = floor(alpha b +
//   xi) random bits, or with probability=non_stratified each bit by itself. A layer keeps its mask instead of
//   its alpha, and is seen through the bits that nothing in front covers.
// - The normalisation needs total alpha, which no list holds that has discarded fragments: R16F, kept in the
//   first pass. composite=accumulated goes without: the list's own transmittance dims the background.
#include "rop/nodes/coverage_masks.h"
#include "rop/nodes/insertion_probability.h"
#include "rop/nodes/stored_layers.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace ropsim {

class Slab {
 public:
    static constexpr TechniqueInfo kInfo = {
        "slab", "stochastic layered alpha blending (Wyman 2016)",
        "layers=8 (1..64), bits=2*layers (1..1024, up to 64 for masks, or inf: the k-buffer end), "
        "coverage=continuous|discrete, probability=stratified|non_stratified, "
        "composite=direct|accumulated|normalised",
        true, "layers=8,bits=16"};
    static constexpr bool kRandom = true;
    static constexpr int kMaxMaskBits = 64;

    Slab(Parameters& parameters, const Screen&)
        : layer_count_(static_cast<int>(parameters.get_integer("layers", 8, 1, kMaxNodes))) {
        discrete_ = parameters.get_choice("coverage", "continuous", {"continuous", "discrete"}) == "discrete";
        stratified_ = parameters.get_choice("probability", "stratified", {"stratified", "non_stratified"}) ==
                      "stratified";
        read_bits(parameters);
        const std::string composite =
            parameters.get_choice("composite", "direct", {"direct", "accumulated", "normalised"});
        direct_ = composite == "direct";
        normalised_ = composite == "normalised";
        tests_ = bits_ > 0 && layer_count_ > 1;
        declare(TechniqueFormats(parameters));
        if (bits_ > 0 && !discrete_)
            probability_ = {bits_, stratified_ ? CoverageBits::kStratified : CoverageBits::kNonStratified};
    }
    const Declaration& declaration() const { return declaration_; }
    bool draws(int pass) const { return bits_ > 0 && pass == 0; }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        if (pass == 1) return accumulate(d, f, pixel);
        return discrete_ ? insert_mask(d, f, pixel) : insert_alpha(d, f, pixel);
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        using Real = typename D::Real;
        path = kResolve;
        if (normalised_) return normalised<D>(background, pixel);
        layers_.fetch(pixel);
        if (!direct_) pixel.fetch_all(accumulated_, 1);
        Rgb<D> color;
        Real behind;
        if (!direct_) {
            color = pixel.load_rgb(accumulated_);
            behind = visible<D>(pixel, layers_.everything<D>());
        } else if (discrete_) {
            const auto composite = composited_masks<D>(layers_, pixel, bits_);
            color = composite.color;
            behind = composite.transmittance;
        } else {
            const auto composite = layers_.composited<D>(pixel);
            color = composite.color;
            behind = composite.transmittance;
        }
        return {color.r + behind * background.mean.r, color.g + behind * background.mean.g,
                color.b + behind * background.mean.b};
    }

    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        for (std::size_t i = 0; i < depths.size(); ++i)
            values[i] = visible<PlainDatapath>(
                pixel, layers_.in_front<PlainDatapath>(pixel, depths[i], EqualDepth::kFragmentInFront));
    }

 private:
    enum Path { kBehindFullList, kInsert, kResolve };

    void read_bits(Parameters& parameters) {
        const std::string text = parameters.get_string("bits", std::to_string(2 * layer_count_));
        if (text != "inf") {
            const int most = discrete_ ? kMaxMaskBits : InsertionProbability::kMaxBits;
            bits_ =
                static_cast<int>(parameters.get_integer("bits", std::min(2 * layer_count_, most), 1, most));
            return;
        }
        if (discrete_)
            throw UserError(parameters.where("bits"),
                            "coverage=discrete keeps a mask of so many bits; use bits=1 to bits=64, or "
                            "coverage=continuous");
        if (!stratified_)
            throw UserError(parameters.where("probability"),
                            "bits=inf inserts always, with no probability; leave probability out");
    }

    void declare(const TechniqueFormats& formats) {
        LayerContents contents;
        contents.color_channels = !direct_ ? 0 : discrete_ ? 3 : 4;
        contents.alpha = !direct_ && !discrete_;
        contents.mask_bits = discrete_ ? bits_ : 0;
        layers_ = {declaration_, formats, layer_count_, contents};
        declaration_.passes = {{"insert", direct_ ? Shading::kFull : Shading::kAlphaOnly}};
        declaration_.paths = {"behind_full_list", "insert", "resolve"};
        const auto path = [&](const char* name) {
            declaration_.paths.emplace_back(name);
            return static_cast<int>(declaration_.paths.size()) - 1;
        };
        if (bits_ > 0) empty_mask_ = path("empty_mask");
        if (tests_) discard_ = path("discard");
        if (!direct_) {
            accumulate_ = path("accumulate");
            unseen_ = path("unseen");
            declaration_.passes.push_back({"accumulate", Shading::kFull});
            const auto fields = declaration_.surface(
                "accumulation", 1, Layout::kInterleaved, Initial::kClear,
                {FieldSpec::real(formats.of("accumulation", Format::kFloat16), 4, 0.0f, ValueRange::kSum)});
            accumulated_ = fields[0];
        }
        if (normalised_)
            total_ = declaration_.surface("total_alpha", 1, Layout::kInterleaved, Initial::kClear,
                                          {FieldSpec::real(formats.of("total_alpha", Format::kFloat16), 1,
                                                           1.0f, ValueRange::kUnit)})[0];
        declaration_.ordering = bits_ > 0 ? Ordering::kRaster : Ordering::kAny;
        // With probabilities, alpha 0 is never inserted; the k-buffer would give it a layer.
        declaration_.zero_alpha_harmless = bits_ > 0;
        declaration_.random = bits_ > 0;
        declaration_.image_format = formats.image();
        // What the list leaves visible of the fragments it has not kept adds up to more than it dims.
        declaration_.light = direct_       ? LightLaw::kLayers
                             : normalised_ ? LightLaw::kScaled
                                           : LightLaw::kConserved;
    }

    // Total alpha sees every fragment, whatever becomes of it in the list.
    template <class D, class P>
    void fetch_total(P& pixel) const {
        if (normalised_) pixel.fetch_all(total_, 1);
    }
    template <class D, class P>
    void dim_total(const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        if (!normalised_) return;
        pixel.write(total_);
        pixel.put(total_, 0, 0, pixel.load(total_) * (Real(1.0f) - f.a));
    }

    template <class D, class P>
    int insert_alpha(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        using Uint = typename D::Uint;
        fetch_total<D>(pixel);
        Uint own(0u);
        if (bits_ > 0) {
            own = probability_.count<D>(f.a);
            if (d.decide(own == Uint(0u))) {
                dim_total<D>(f, pixel);
                return empty_mask_;
            }
        }
        layers_.fetch(pixel);
        dim_total<D>(f, pixel);
        const auto front = layers_.in_front<D>(pixel, f.z, EqualDepth::kFragmentBehind);
        if (d.decide(layers_.all<D>(front))) return kBehindFullList;
        if (tests_) {
            const Uint covered = probability_.count<D>(Real(1.0f) - layers_.transmittance<D>(pixel, front));
            const Real probability = probability_.look_up<D>(covered, own);
            if (d.decide(inverse(draw_unit<D>(f.key, 0) < probability))) return discard_;
        }
        layers_.insert<D>(pixel, front,
                          layers_.converted<D>(pixel, f.z, f.premultiplied, f.a, MaskWords<D>{0u, 0u}));
        return kInsert;
    }

    template <class D, class P>
    int insert_mask(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Uint = typename D::Uint;
        fetch_total<D>(pixel);
        const int words = layers_.mask_words();
        // How many bits a random subset has is known before which they are.
        const Uint count = stratified_ ? bits_wanted<D>(f) : Uint(0u);
        MaskWords<D> own{0u, 0u};
        if (!stratified_) own = words_of<D>(coin_mask<D>(f.key, f.a, bits_), bits_);
        if (d.decide(stratified_ ? count == Uint(0u) : empty<D>(own, words))) {
            dim_total<D>(f, pixel);
            return empty_mask_;
        }
        if (stratified_) own = words_of<D>(subset<D>(f, count), bits_);
        layers_.fetch(pixel);
        dim_total<D>(f, pixel);
        const auto front = layers_.in_front<D>(pixel, f.z, EqualDepth::kFragmentBehind);
        if (d.decide(layers_.all<D>(front))) return kBehindFullList;
        if (tests_) {
            const MaskWords<D> seen = without<D>(own, covered<D>(layers_, pixel, front), words);
            if (d.decide(empty<D>(seen, words))) return discard_;
        }
        layers_.insert<D>(pixel, front, layers_.converted<D>(pixel, f.z, f.straight(), f.a, own));
        return kInsert;
    }
    template <class D>
    typename D::Uint bits_wanted(const FragmentInput<D>& f) const {
        using Real = typename D::Real;
        return floor_to_uint(f.a * Real(static_cast<float>(bits_)) + draw_unit<D>(f.key, 0));
    }
    template <class D>
    SampleMask<D> subset(const FragmentInput<D>& f, const typename D::Uint& count) const {
        const auto n = static_cast<std::uint32_t>(bits_);
        return random_subset<D>(f.key, count, mask_at<D>(low_bits(n), 0), typename D::Uint(n), bits_);
    }

    // The share of a pixel that the layers in front leave visible.
    template <class D, class P>
    typename D::Real visible(P& pixel, const LayersInFront<D>& front) const {
        if (!discrete_) return layers_.transmittance<D>(pixel, front);
        return uncovered<D>(covered<D>(layers_, pixel, front), layers_.mask_words(), bits_);
    }
    template <class D, class P>
    int accumulate(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        layers_.fetch(pixel);
        pixel.fetch_all(accumulated_, 1);
        const Real seen = visible<D>(pixel, layers_.in_front<D>(pixel, f.z, EqualDepth::kFragmentInFront));
        if (d.decide(seen <= Real(0.0f))) return unseen_;
        const std::array<Real, 4> more = {f.premultiplied.r, f.premultiplied.g, f.premultiplied.b, f.a};
        pixel.write(accumulated_);
        for (int c = 0; c < 4; ++c)
            pixel.put(accumulated_, 0, c,
                      saturated(accumulated_,
                                pixel.load(accumulated_, 0, c) + seen * more[static_cast<std::size_t>(c)]));
        return accumulate_;
    }
    // D of Enderton et al. 2011, section 4.2.
    template <class D, class P>
    Rgb<D> normalised(const Background<D>& background, P& pixel) const {
        using Real = typename D::Real;
        pixel.fetch_all(accumulated_, 1);
        pixel.fetch_all(total_, 1);
        const Rgb<D> sum = pixel.load_rgb(accumulated_);
        const Real weight = pixel.load(accumulated_, 0, 3);
        const Real clear = pixel.load(total_);
        const auto empty = weight <= Real(0.0f);
        const Real factor =
            select(empty, Real(0.0f), (Real(1.0f) - clear) / select(empty, Real(1.0f), weight));
        return {sum.r * factor + clear * background.mean.r, sum.g * factor + clear * background.mean.g,
                sum.b * factor + clear * background.mean.b};
    }

    int layer_count_;
    int bits_ = 0;  // 0: inf
    bool discrete_ = false;
    bool tests_ = false;  // behind the one layer of a list of one there is no place to be tested for
    bool stratified_ = true;
    bool direct_ = true;
    bool normalised_ = false;
    int discard_ = -1;
    int empty_mask_ = -1;
    int accumulate_ = -1;
    int unseen_ = -1;
    InsertionProbability probability_;
    StoredLayers layers_;
    Declaration declaration_;
    Field accumulated_;
    Field total_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(slab, Slab)
