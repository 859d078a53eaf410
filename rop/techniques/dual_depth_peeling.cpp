// Dual depth peeling: Bavoil and Myers 2008 ("Order independent transparency with dual depth peeling"). A
// first pass finds the nearest and the furthest depth of each sample. Each peel then composites the fragments
// at these two depths, the near one under the front colour and the far one over the back colour, and finds
// the range of what is left strictly between: L / 2 + 1 passes for L layers.
//
// Stored for each spatial sample: two ranges of depth, that of the pass before and that of this one, which
// change roles from pass to pass (2 x 64 bits), and the front and back colours with their transmittance
// (RGBA16F, 64 bits each). The three targets of a pass, its range and the two colours, are the 192 bits that
// the authors render to, read and written by MAX blending: 24 + 24 bytes a fragment at most. The range of the
// pass before is 64 bits and 8 bytes read more; on their machine it is a texture that the shader reads.
//
// Deviations. Colours are blended in place, where a machine that can only blend by MAX keeps a second copy of
// the front colour and blends the back colour in a pass of its own. A fragment that is at neither end of the
// range does not touch the colours, and one outside touches nothing but the ranges. No buffer is cleared
// between passes: a range that encloses the one of the pass before is two passes old. Fragments of equal
// depth are composited in the same pass in order of arrival, each under (in front) or over (at the back)
// those before; their light is all there, but at the back the earliest comes out furthest.
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <array>

namespace ropsim {

class DualDepthPeeling {
 public:
    static constexpr TechniqueInfo kInfo = {"dual_depth_peeling",
                                            "dual depth peeling, from both ends (Bavoil and Myers 2008)",
                                            "layers=4096 (1..4096, two a pass)", false, ""};
    // More than any scene has: peeling ends when nothing is left.
    static constexpr int kMostLayers = 4096;

    DualDepthPeeling(Parameters& parameters, const Screen& screen) : samples_(screen.samples) {
        const auto layers = static_cast<int>(parameters.get_integer("layers", kMostLayers, 1, kMostLayers));
        const TechniqueFormats formats(parameters);
        const Format depth = formats.of("depth", Format::kFloat32);
        if (stored_value(depth, kNoNear) != kNoNear || stored_value(depth, kNoFar) != kNoFar)
            throw UserError(parameters.where("depth_format"),
                            fmt::format("{} has no values outside of [0, 1], which mark an empty range; use "
                                        "float32 or float16",
                                        format_info(depth).name));
        const Format color = formats.of("color", Format::kFloat16);
        const auto range = declaration_.surface("range", 2 * samples_, Layout::kPlanar, Initial::kClear,
                                                {FieldSpec::real(depth, 1, kNoNear, ValueRange::kUnit),
                                                 FieldSpec::real(depth, 1, kNoFar, ValueRange::kUnit)});
        near_ = range[0];
        far_ = range[1];
        front_ = declare_color("front_color", color);
        back_ = declare_color("back_color", color);
        declaration_.passes = {{"range", Shading::kAlphaOnly}, {"peel", Shading::kFull}};
        declaration_.paths = {"range", "outside", "end", "inside", "resolve"};
        declaration_.repeat = {1, 1, (layers + 1) / 2, kInside};
        declaration_.ordering = Ordering::kAny;
        // A layer of no effect moves the middle, and so which layers are added up from which end.
        declaration_.zero_alpha_harmless = false;
        declaration_.uses_coverage = true;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        if (pass == 0) return find_range<D>(f, pixel);
        return peel(d, f, pixel);
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        using Real = typename D::Real;
        path = kResolve;
        pixel.fetch_all(front_.color, samples_);
        pixel.fetch_all(back_.color, samples_);
        Rgb<D> total{Real(0.0f), Real(0.0f), Real(0.0f)};
        for (int m = 0; m < samples_; ++m) {
            const Rgb<D>& behind = background.sample[static_cast<std::size_t>(m)];
            const Rgb<D> back =
                over<D>(pixel.load_rgb(back_.color, m), pixel.load(back_.transmittance, m), behind);
            const Rgb<D> all =
                over<D>(pixel.load_rgb(front_.color, m), pixel.load(front_.transmittance, m), back);
            total = m == 0 ? all : Rgb<D>{total.r + all.r, total.g + all.g, total.b + all.b};
        }
        if (samples_ == 1) return total;
        const Real share(1.0f / static_cast<float>(samples_));
        return {total.r * share, total.g * share, total.b * share};
    }

 private:
    enum Path { kRange, kOutside, kEnd, kInside, kResolve };
    // An empty range: every depth is nearer than its near end and further than its far end.
    static constexpr float kNoNear = 2.0f;
    static constexpr float kNoFar = -1.0f;

    struct Color {
        Field color;
        Field transmittance;
    };
    template <class D>
    struct Decision {
        typename D::Bool front, back, inside;
    };
    template <class D>
    using Decisions = std::array<Decision<D>, kMaxSpatialSamples>;

    Color declare_color(const std::string& name, Format format) {
        const auto fields = declaration_.surface(name, samples_, Layout::kPlanar, Initial::kClear,
                                                 {FieldSpec::real(format, 3, 0.0f, ValueRange::kColor),
                                                  FieldSpec::real(format, 1, 1.0f, ValueRange::kUnit)});
        return {fields[0], fields[1]};
    }
    // Premultiplied `a` of transmittance `t` over `b`.
    template <class D>
    static Rgb<D> over(const Rgb<D>& a, const typename D::Real& t, const Rgb<D>& b) {
        return {a.r + t * b.r, a.g + t * b.g, a.b + t * b.b};
    }

    template <class D, class P>
    int find_range(const FragmentInput<D>& f, P& pixel) const {
        for (int m = 0; m < samples_; ++m) pixel.fetch_if(bit(f.coverage, m), near_, 2 * m);
        for (int m = 0; m < samples_; ++m) {
            const auto z = pixel.as_stored(near_, f.depth_at(m));
            widen<D>(pixel, 2 * m, pixel.load(near_, 2 * m), pixel.load(far_, 2 * m), z, bit(f.coverage, m));
        }
        return kRange;
    }
    // Puts the range (near, far) with z in it into `element`, where `covered`.
    template <class D, class P>
    void widen(P& pixel, int element, const typename D::Real& near, const typename D::Real& far,
               const typename D::Real& z, const typename D::Bool& covered) const {
        const auto nearer = z < near;
        const auto further = far < z;
        pixel.write_if(both(covered, either(nearer, further)), near_, element);
        pixel.put_if(both(covered, nearer), near_, element, 0, z);
        pixel.put_if(both(covered, further), far_, element, 0, z);
    }

    template <class D, class P>
    int peel(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Bool = typename D::Bool;
        for (int m = 0; m < samples_; ++m)
            for (int which = 0; which < 2; ++which) pixel.fetch_if(bit(f.coverage, m), near_, 2 * m + which);
        Decisions<D> decided;
        Bool any_inside(false);
        Bool any_end(false);
        for (int m = 0; m < samples_; ++m) {
            const Decision<D> one = decide_sample(f, pixel, m);
            const Bool end = either(one.front, one.back);
            decided[static_cast<std::size_t>(m)] = one;
            any_inside = m == 0 ? one.inside : either(any_inside, one.inside);
            any_end = m == 0 ? end : either(any_end, end);
        }
        const bool inside = d.decide(any_inside);
        // With one sample a fragment inside is at no end.
        if (inside && samples_ == 1) return kInside;
        if (!inside && !d.decide(any_end)) return kOutside;
        composite<D>(f, pixel, decided, any_end);
        return inside ? kInside : kEnd;
    }

    // Where the fragment stands in sample m's range, and the next range with it.
    template <class D, class P>
    Decision<D> decide_sample(const FragmentInput<D>& f, P& pixel, int m) const {
        using Real = typename D::Real;
        using Bool = typename D::Bool;
        const int before = 2 * m + (f.round & 1);
        const int next = 2 * m + 1 - (f.round & 1);
        const Real z = pixel.as_stored(near_, f.depth_at(m));
        const Real near = pixel.load(near_, before);
        const Real far = pixel.load(far_, before);
        const Bool covered = bit(f.coverage, m);
        const Bool from_near = both(covered, near <= z);
        const Bool past_near = both(covered, near < z);
        const Bool to_far = z <= far;
        const Bool inside = both(past_near, z < far);
        const Bool at_near = both(from_near, inverse(past_near));
        // A range that begins nearer than the one before is not of this pass: it is empty as yet.
        const Real old_near = pixel.load(near_, next);
        const Real old_far = pixel.load(far_, next);
        const Bool stale = both(covered, old_near < near);
        const Real next_near = select(stale, Real(kNoNear), old_near);
        const Real next_far = select(stale, Real(kNoFar), old_far);
        const Bool nearer = both(inside, z < next_near);
        const Bool further = both(inside, next_far < z);
        pixel.write_if(either(stale, either(nearer, further)), near_, next);
        pixel.put(near_, next, 0, select(nearer, z, next_near));
        pixel.put(far_, next, 0, select(further, z, next_far));
        // At the far end: not behind it, and neither inside nor at the near end, which a last layer counts
        // as.
        const Bool at_far = both(both(past_near, to_far), inverse(inside));
        return {at_near, at_far, inside};
    }

    template <class D, class P>
    void composite(const FragmentInput<D>& f, P& pixel, const Decisions<D>& decided,
                   const typename D::Bool& any) const {
        using Real = typename D::Real;
        pixel.next_fetch_stage(any);
        for (int m = 0; m < samples_; ++m) {
            pixel.fetch_if(decided[static_cast<std::size_t>(m)].front, front_.color, m);
            pixel.fetch_if(decided[static_cast<std::size_t>(m)].back, back_.color, m);
        }
        const Real through = Real(1.0f) - f.a;
        for (int m = 0; m < samples_; ++m) {
            const Decision<D>& one = decided[static_cast<std::size_t>(m)];
            const Real in_front = pixel.load(front_.transmittance, m);
            put_color<D>(pixel, front_, m, one.front,
                         over<D>(pixel.load_rgb(front_.color, m), in_front, f.premultiplied),
                         in_front * through);
            put_color<D>(pixel, back_, m, one.back,
                         over<D>(f.premultiplied, through, pixel.load_rgb(back_.color, m)),
                         through * pixel.load(back_.transmittance, m));
        }
    }
    template <class D, class P>
    void put_color(P& pixel, const Color& to, int m, const typename D::Bool& where, const Rgb<D>& color,
                   const typename D::Real& transmittance) const {
        pixel.write_if(where, to.color, m);
        pixel.put_rgb_if(where, to.color, m, color);
        pixel.put_if(where, to.transmittance, m, 0, transmittance);
    }

    int samples_;
    Declaration declaration_;
    Field near_;
    Field far_;
    Color front_;
    Color back_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(dual_depth_peeling, DualDepthPeeling)
