// k-buffer: Bavoil, Callahan, Lefohn, Comba and Silva 2007: a pixel's k nearest fragments, sorted, and how
// many there are, read, modified and written by every fragment. The paper leaves to a program of its own what
// is done with k + 1 fragments; taken here is the program that captures the first k layers: the furthest of
// the k + 1 is dropped. (Published code that merges it into the last layer instead is multi-layer alpha
// blending.) The count is published code's; the last layer's depth would tell as much. Of equal depths the
// earlier arrival is nearer. The paper's hardware hazards, two fragments of one pixel in flight at once, do
// not exist where operations on a pixel are atomic.
#include "rop/nodes/stored_layers.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <cstdint>
#include <span>

namespace ropsim {

class KBuffer {
 public:
    static constexpr TechniqueInfo kInfo = {"k_buffer", "k-buffer (Bavoil et al. 2007)", "layers=8 (1..64)",
                                            false, ""};

    KBuffer(Parameters& parameters, const Screen&)
        : layer_count_(static_cast<int>(parameters.get_integer("layers", 8, 1, kMaxNodes))) {
        const TechniqueFormats formats(parameters);
        layers_ = {declaration_, formats, layer_count_, {}};
        count_ = declaration_.surface("count", 1, Layout::kInterleaved, Initial::kClear,
                                      {FieldSpec::integer(32, 0)})[0];
        declaration_.passes = {{"insert", Shading::kFull}};
        declaration_.paths = {"append", "replace", "dropped", "resolve"};
        declaration_.ordering = Ordering::kAny;
        declaration_.zero_alpha_harmless = false;  // it takes a layer
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        using Uint = typename D::Uint;
        pixel.fetch_all(count_, 1);
        layers_.fetch(pixel);
        const Uint count = pixel.load_bits(count_);
        const auto front = layers_.in_front<D>(pixel, f.z, EqualDepth::kFragmentBehind);
        const auto full = count == Uint(static_cast<std::uint32_t>(layer_count_));
        const auto incoming = layers_.converted<D>(pixel, f.z, f.premultiplied, f.a, {0u, 0u});
        if (!d.decide(full)) {
            layers_.insert<D>(pixel, front, incoming);
            pixel.write(count_);
            pixel.put_bits(count_, 0, 0, count + Uint(1u));
            return kAppend;
        }
        if (d.decide(layers_.all<D>(front))) return kDropped;
        layers_.insert<D>(pixel, front, incoming);
        return kReplace;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        path = kResolve;
        layers_.fetch(pixel);
        const auto [color, behind] = layers_.composited<D>(pixel);
        return {color.r + behind * background.mean.r, color.g + behind * background.mean.g,
                color.b + behind * background.mean.b};
    }

    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        for (std::size_t i = 0; i < depths.size(); ++i)
            values[i] = layers_.transmittance<PlainDatapath>(
                pixel, layers_.in_front<PlainDatapath>(pixel, depths[i], EqualDepth::kFragmentInFront));
    }

 private:
    enum Path { kAppend, kReplace, kDropped, kResolve };

    int layer_count_;
    StoredLayers layers_;
    Declaration declaration_;
    Field count_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(k_buffer, KBuffer)
