// Depth peeling, front to back: Everitt 2001 ("Interactive order-independent transparency"), as Enderton et
// al. 2011 compare with in section 5. Each round peels one layer a pixel: of the fragments behind the layer
// before, the nearest stays, and an image pass blends it under what has been accumulated. Peeling goes on
// until a round keeps nothing (an occlusion query tells) or `layers` rounds have run.
//
// Stored for each spatial sample: two depths, of the layer before and of this one, which change roles from
// round to round (64 bits), this layer as straight RGBA8 (32 bits) and the accumulated colour (64 bits). A
// fragment reads both depths and writes one and the layer: 8 + 8 bytes at most.
//
// Deviations, and what the paper leaves open. No buffer is cleared between rounds: the older depth of the
// pair is known by being no further than the newer, and the blend pass empties the layer that it has read.
// Fragments of equal depth are one layer with `ties=collapse`, as with any peeling by depth alone: the
// earliest arrival stays, the others are lost. `ties=primitive` peels them one by one, by draw call and then
// primitive, which is the order of arrival at a pixel of a trace as captured; this stores the two layers'
// numbers too (64 bits, 8 bytes read, 4 written). Straight colour loses light that is added with no alpha.
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <array>

namespace ropsim {

class DepthPeeling {
 public:
    static constexpr TechniqueInfo kInfo = {"depth_peeling", "depth peeling, front to back (Everitt 2001)",
                                            "layers=4096 (1..4096), ties=collapse|primitive", false, ""};
    // More than any scene has: peeling ends when nothing is left.
    static constexpr int kMostLayers = 4096;

    DepthPeeling(Parameters& parameters, const Screen& screen)
        : samples_(screen.samples),
          by_primitive_(parameters.get_choice("ties", "collapse", {"collapse", "primitive"}) == "primitive") {
        const auto layers = static_cast<int>(parameters.get_integer("layers", kMostLayers, 1, kMostLayers));
        const std::size_t draws = screen.objects.empty() ? kMostDraws : screen.objects.size();
        primitive_bits_ = 32 - static_cast<int>(std::bit_width(static_cast<std::uint32_t>(draws - 1)));
        const TechniqueFormats formats(parameters);
        const Format depth = formats.of("depth", Format::kFloat32);
        if (stored_value(depth, kNoLayer) != kNoLayer)
            throw UserError(
                parameters.where("depth_format"),
                fmt::format("{} has no value in front of every depth, which marks a pixel without a "
                            "layer; use float32 or float16",
                            format_info(depth).name));
        const Format color = formats.of("color", Format::kFloat16);
        declare_surfaces(depth, formats.of("layer", Format::kUnorm8), color);
        declaration_.passes = {{"peel", Shading::kFull}, {"blend", Shading::kFull, PassKind::kImage}};
        declaration_.paths = {"other_layer", "keep", "blend", "resolve"};
        declaration_.repeat = {0, 1, layers, kKeep};
        declaration_.ordering = Ordering::kAny;
        // A fragment of no effect takes up a layer, and hides others of its depth.
        declaration_.zero_alpha_harmless = by_primitive_ && layers == kMostLayers;
        declaration_.uses_coverage = true;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        using Bool = typename D::Bool;
        const int now = f.round & 1;  // the pair's element of this round's layer
        for (int m = 0; m < samples_; ++m) {
            for (int which = 0; which < 2; ++which) {
                pixel.fetch_if(bit(f.coverage, m), depth_, 2 * m + which);
                if (by_primitive_) pixel.fetch_if(bit(f.coverage, m), order_, 2 * m + which);
            }
        }
        std::array<Bool, kMaxSpatialSamples> kept;
        std::array<Place<D>, kMaxSpatialSamples> place;
        Bool any(false);
        for (int m = 0; m < samples_; ++m) {
            const auto k = static_cast<std::size_t>(m);
            place[k] = {pixel.as_stored(depth_, f.depth_at(m)), order_of<D>(f.order)};
            const Place<D> before = place_at<D>(pixel, 2 * m + 1 - now);
            const Place<D> nearest = place_at<D>(pixel, 2 * m + now);
            const Bool behind = nearer<D>(before, place[k]);
            const Bool first = inverse(nearer<D>(before, nearest));  // the older of the pair: to be replaced
            const Bool wins = either(first, nearer<D>(place[k], nearest));
            kept[k] = both(bit(f.coverage, m), both(behind, wins));
            any = m == 0 ? kept[k] : either(any, kept[k]);
        }
        if (!d.decide(any)) return kOtherLayer;
        for (int m = 0; m < samples_; ++m)
            keep<D>(f, pixel, m, now, kept[static_cast<std::size_t>(m)], place[static_cast<std::size_t>(m)]);
        return kKeep;
    }

    // Under: what is accumulated is in front.
    template <class D, class P>
    int image_pass(D&, int, P& pixel) const {
        using Real = typename D::Real;
        using Bool = typename D::Bool;
        pixel.fetch_all(layer_, samples_);
        std::array<Real, kMaxSpatialSamples> alpha;
        std::array<Rgb<D>, kMaxSpatialSamples> color;
        std::array<Bool, kMaxSpatialSamples> full;
        Bool any(false);
        for (int m = 0; m < samples_; ++m) {
            const auto k = static_cast<std::size_t>(m);
            color[k] = pixel.load_rgb(layer_, m);
            alpha[k] = pixel.load(layer_, m, 3);
            full[k] = Real(0.0f) < alpha[k];
            any = m == 0 ? full[k] : either(any, full[k]);
        }
        pixel.next_fetch_stage(any);
        for (int m = 0; m < samples_; ++m) pixel.fetch_if(full[static_cast<std::size_t>(m)], accumulated_, m);
        for (int m = 0; m < samples_; ++m) {
            const auto k = static_cast<std::size_t>(m);
            const Real transmittance = pixel.load(transmittance_, m);
            const Real weight = transmittance * alpha[k];
            const Rgb<D> sum = pixel.load_rgb(accumulated_, m);
            pixel.write_if(full[k], accumulated_, m);
            pixel.put_rgb_if(
                full[k], accumulated_, m,
                {sum.r + weight * color[k].r, sum.g + weight * color[k].g, sum.b + weight * color[k].b});
            pixel.put_if(full[k], transmittance_, m, 0, transmittance * (Real(1.0f) - alpha[k]));
            pixel.write_if(full[k], layer_, m);
            pixel.put_rgb_if(full[k], layer_, m, {Real(0.0f), Real(0.0f), Real(0.0f)});
            pixel.put_if(full[k], layer_, m, 3, Real(0.0f));
        }
        return kBlend;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        using Real = typename D::Real;
        path = kResolve;
        pixel.fetch_all(accumulated_, samples_);
        Rgb<D> total{Real(0.0f), Real(0.0f), Real(0.0f)};
        for (int m = 0; m < samples_; ++m) {
            const Rgb<D> sum = pixel.load_rgb(accumulated_, m);
            const Rgb<D>& behind = background.sample[static_cast<std::size_t>(m)];
            const Real t = pixel.load(transmittance_, m);
            const Rgb<D> color{sum.r + t * behind.r, sum.g + t * behind.g, sum.b + t * behind.b};
            total = m == 0 ? color : Rgb<D>{total.r + color.r, total.g + color.g, total.b + color.b};
        }
        if (samples_ == 1) return total;
        const Real share(1.0f / static_cast<float>(samples_));
        return {total.r * share, total.g * share, total.b * share};
    }

 private:
    enum Path { kOtherLayer, kKeep, kBlend, kResolve };
    static constexpr float kNoLayer = -1.0f;  // in front of every depth
    static constexpr std::size_t kMostDraws = 65536;

    // Where a fragment or a layer stands among those of its sample.
    template <class D>
    struct Place {
        typename D::Real depth;
        typename D::Uint order;
    };

    void declare_surfaces(Format depth, Format layer, Format color) {
        depth_ = declaration_.surface("depth", 2 * samples_, Layout::kPlanar, Initial::kClear,
                                      {FieldSpec::real(depth, 1, kNoLayer, ValueRange::kUnit)})[0];
        layer_ = declaration_.surface("layer", samples_, Layout::kPlanar, Initial::kClear,
                                      {FieldSpec::real(layer, 4, 0.0f, ValueRange::kColor)})[0];
        const auto accumulated =
            declaration_.surface("accumulated_color", samples_, Layout::kPlanar, Initial::kClear,
                                 {FieldSpec::real(color, 3, 0.0f, ValueRange::kColor),
                                  FieldSpec::real(color, 1, 1.0f, ValueRange::kUnit)});
        accumulated_ = accumulated[0];
        transmittance_ = accumulated[1];
        if (by_primitive_)
            order_ = declaration_.surface("order", 2 * samples_, Layout::kPlanar, Initial::kClear,
                                          {FieldSpec::integer(32, 0)})[0];
    }

    // Draw call and primitive in 32 bits, never 0, as the rasteriser hands them down. Primitives past what
    // the draw calls leave room for (2^16 of them at the least) collapse.
    template <class D>
    typename D::Uint order_of(const DrawOrder& order) const {
        const std::uint32_t most = primitive_bits_ == 32 ? ~0u : (1u << primitive_bits_) - 1;
        const std::uint32_t number = std::min(order.primitive + 1, most);
        return primitive_bits_ == 32 ? number : order.draw << primitive_bits_ | number;
    }
    template <class D, class P>
    Place<D> place_at(P& pixel, int element) const {
        if (!by_primitive_) return {pixel.load(depth_, element), {}};
        return {pixel.load(depth_, element), pixel.load_bits(order_, element)};
    }
    template <class D>
    typename D::Bool nearer(const Place<D>& a, const Place<D>& b) const {
        const typename D::Bool closer = a.depth < b.depth;
        if (!by_primitive_) return closer;
        return either(closer, both(a.depth <= b.depth, a.order < b.order));
    }
    template <class D, class P>
    void keep(const FragmentInput<D>& f, P& pixel, int m, int now, const typename D::Bool& kept,
              const Place<D>& place) const {
        pixel.write_if(kept, depth_, 2 * m + now);
        pixel.put_if(kept, depth_, 2 * m + now, 0, place.depth);
        if (by_primitive_) {
            pixel.write_if(kept, order_, 2 * m + now);
            const typename D::Uint old = pixel.load_bits(order_, 2 * m + now);
            pixel.put_bits(order_, 2 * m + now, 0, select(kept, place.order, old));
        }
        pixel.write_if(kept, layer_, m);
        pixel.put_rgb_if(kept, layer_, m, f.straight());
        pixel.put_if(kept, layer_, m, 3, f.a);
    }

    int samples_;
    bool by_primitive_;
    int primitive_bits_ = 32;  // of the order
    Declaration declaration_;
    Field depth_;
    Field layer_;
    Field accumulated_;
    Field transmittance_;
    Field order_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(depth_peeling, DepthPeeling)
