// Hybrid transparency: Maule, Comba, Torchelsen and Bastos 2013: the k nearest fragments sorted, and a tail
// that sums all others without order: colour, alpha, count. The tail is composited behind the k as `count`
// layers of its mean colour and mean alpha: sum(a c) / sum(a) * (1 - (1 - mean a)^count). The tail's 8 bytes
// are laid out as in the published port (PixelSyncOIT): colour sums in 10 bits and the alpha sum in 16, in
// steps of 1/255, and a 16-bit count. The port lets sums wrap (tail_format=packed_wrapping); here they
// saturate by default. tail_factor=off is the port's resolve, which adds the mean colour without the last
// factor while it dims the background by all of it. Decided here: of equal depths the earlier arrival is
// nearer (the port: the later). A fragment that falls out of the list, or never gets in, enters the tail as a
// layer would have stored it, so that order of arrival makes no difference. A tail of alpha 0 adds its colour
// unscaled, the limit of the formula.
#include "rop/nodes/stored_layers.h"
#include "rop/nodes/weighted_tail.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <cstdint>
#include <span>

namespace ropsim {

class Hybrid {
 public:
    static constexpr TechniqueInfo kInfo = {
        "hybrid", "hybrid transparency (Maule et al. 2013)",
        "layers=8 (1..64), tail_factor=on|off, tail_format=packed|packed_wrapping|float16|float32", false,
        ""};

    Hybrid(Parameters& parameters, const Screen&)
        : layer_count_(static_cast<int>(parameters.get_integer("layers", 8, 1, kMaxNodes))),
          factor_(parameters.get_choice("tail_factor", "on", {"on", "off"}) == "on") {
        const TechniqueFormats formats(parameters);
        layers_ = {declaration_, formats, layer_count_, {}};
        tail_ = {declaration_, parameters, formats};
        declaration_.passes = {{"insert", Shading::kFull}};
        declaration_.paths = {"insert", "insert_evict", "tail", "resolve"};
        declaration_.ordering = Ordering::kAny;
        declaration_.zero_alpha_harmless = false;  // it takes a layer, or counts in the tail
        declaration_.image_format = formats.image();
        if (!factor_) declaration_.light = LightLaw::kAdded;
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        layers_.fetch(pixel);
        tail_.fetch(pixel);
        const auto front = layers_.in_front<D>(pixel, f.z, EqualDepth::kFragmentBehind);
        const auto incoming = layers_.converted<D>(pixel, f.z, f.premultiplied, f.a, {0u, 0u});
        if (!d.decide(layers_.full<D>(pixel))) {
            layers_.insert<D>(pixel, front, incoming);
            return kInsert;
        }
        if (d.decide(layers_.all<D>(front))) {
            tail_.add<D>(pixel, layers_.color<D>(incoming), layers_.alpha<D>(incoming));
            return kTail;
        }
        const int last = layer_count_ - 1;
        tail_.add<D>(pixel, layers_.color(pixel, last), layers_.alpha(pixel, last));
        layers_.insert<D>(pixel, front, incoming);
        return kInsertEvict;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        using Real = typename D::Real;
        path = kResolve;
        layers_.fetch(pixel);
        tail_.fetch(pixel);
        const auto [color, core] = layers_.composited<D>(pixel);
        const auto tail = tail_.load<D>(pixel);
        const auto weights = tail_.weights<D>(tail, factor_);
        const Real scale = core * weights.scale;
        const Real behind = core * weights.transmittance;
        return {color.r + scale * tail.sum.r + behind * background.mean.r,
                color.g + scale * tail.sum.g + behind * background.mean.g,
                color.b + scale * tail.sum.b + behind * background.mean.b};
    }

    // Behind a full list the composite gives every fragment of the tail the same weight.
    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        const auto tail = tail_.load<PlainDatapath>(pixel);
        const float scale = tail.count > 0 ? tail_.weights<PlainDatapath>(tail, factor_).scale : 1.0f;
        for (std::size_t i = 0; i < depths.size(); ++i) {
            const auto front =
                layers_.in_front<PlainDatapath>(pixel, depths[i], EqualDepth::kFragmentInFront);
            values[i] = layers_.transmittance<PlainDatapath>(pixel, front) *
                        (front.count == layer_count_ ? scale : 1.0f);
        }
    }

 private:
    enum Path { kInsert, kInsertEvict, kTail, kResolve };

    int layer_count_;
    bool factor_;
    StoredLayers layers_;
    WeightedTail tail_;
    Declaration declaration_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(hybrid, Hybrid)
