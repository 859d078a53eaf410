// k-buffer: Bavoil, Callahan, Lefohn, Comba and Silva 2007: a pixel's k nearest fragments, sorted, and how
// many there are, read, modified and written by every fragment. The paper leaves to a program of its own what
// is done with k + 1 fragments; taken here is the program that captures the first k layers: the furthest of
// the k + 1 is dropped. (Published code that merges it into the last layer instead is multi-layer alpha
// blending.) The count is published code's; the last layer's depth would tell as much. Of equal depths the
// earlier arrival is nearer. The paper's hardware hazards, two fragments of one pixel in flight at once, do
// not exist where operations on a pixel are atomic.
#include "rop/nodes/counted_layers.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <cstdint>
#include <span>

namespace ropsim {

class KBuffer {
 public:
    static constexpr TechniqueInfo kInfo = {"k_buffer", "k-buffer (Bavoil et al. 2007)", "layers=8 (1..64)",
                                            false, ""};

    KBuffer(Parameters& parameters, const Screen&) {
        const auto layers = static_cast<int>(parameters.get_integer("layers", 8, 1, kMaxNodes));
        const TechniqueFormats formats(parameters);
        counted_ = {declaration_, formats, layers};
        declaration_.passes = {{"insert", Shading::kFull}};
        declaration_.paths = {"append", "replace", "dropped", "resolve"};
        declaration_.ordering = Ordering::kAny;
        declaration_.zero_alpha_harmless = false;  // it takes a layer
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        return counted_.insert<D>(d, f.z, f.premultiplied, f.a, pixel);
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        path = kResolve;
        counted_.layers().fetch(pixel);
        const auto [color, behind] = counted_.layers().composited<D>(pixel);
        return {color.r + behind * background.mean.r, color.g + behind * background.mean.g,
                color.b + behind * background.mean.b};
    }

    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        const StoredLayers& layers = counted_.layers();
        for (std::size_t i = 0; i < depths.size(); ++i)
            values[i] = layers.transmittance<PlainDatapath>(
                pixel, layers.in_front<PlainDatapath>(pixel, depths[i], EqualDepth::kFragmentInFront));
    }

 private:
    static constexpr int kResolve = 3;  // behind the outcomes of an insertion

    CountedLayers counted_;
    Declaration declaration_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(k_buffer, KBuffer)
