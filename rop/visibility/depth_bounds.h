// The depths between which a pixel's visibility map lies, kept a spatial sample: the nearest and the furthest
// fragment (8 bytes), or the nearest alone.
#pragma once

#include "rop/technique.h"
#include "rop/technique_formats.h"
#include "rop/visibility/map_options.h"

#include <array>

namespace ropsim {

class DepthBounds {
 public:
    DepthBounds() = default;
    // Declares the surface "bounds", unless the bounds are the frame's or kept in registers.
    DepthBounds(Declaration& declaration, const TechniqueFormats& formats, const MapOptions& options)
        : bounds_(options.bounds), samples_(options.spatial_samples), inverse_(1.0f / options.depth_range) {
        if (bounds_ == MapBounds::kFrame || options.memory == MapMemory::kVariable) return;
        const Format format = formats.of("bounds", Format::kFloat32);
        std::vector<FieldSpec> fields = {FieldSpec::real(format, 1, kNone, ValueRange::kUnit)};
        if (bounds_ == MapBounds::kPixel)
            fields.push_back(FieldSpec::real(format, 1, -kNone, ValueRange::kUnit));
        const auto handles =
            declaration.surface("bounds", samples_, Layout::kInterleaved, Initial::kClear, fields);
        nearest_ = handles.front();
        furthest_ = handles.back();
    }

    template <class D>
    struct Range {
        typename D::Real nearest = kNone;
        typename D::Real furthest = -kNone;
    };

    // The bounds pass. False where the fragment lies inside already: a control path.
    template <class D, class P>
    bool widen(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Bool = typename D::Bool;
        fetch<D>(f, pixel);
        std::array<Bool, kMaxSpatialSamples> outside;
        std::array<Range<D>, kMaxSpatialSamples> wider;
        Bool any(false);
        for (int m = 0; m < samples_; ++m) {
            const auto k = static_cast<std::size_t>(m);
            const auto z = pixel.as_stored(nearest_, f.depth_at(m));
            const Range<D> range = load<D>(pixel, m);
            Bool beyond = z < range.nearest;
            wider[k].nearest = select(beyond, z, range.nearest);
            if (bounds_ == MapBounds::kPixel) {
                const Bool behind = range.furthest < z;
                wider[k].furthest = select(behind, z, range.furthest);
                beyond = either(beyond, behind);
            }
            outside[k] = both(bit(f.coverage, m), beyond);
            any = m == 0 ? outside[k] : either(any, outside[k]);
        }
        if (!d.decide(any)) return false;
        for (int m = 0; m < samples_; ++m) {
            const auto k = static_cast<std::size_t>(m);
            pixel.write_if(outside[k], nearest_, m);
            pixel.put_if(outside[k], nearest_, m, 0, wider[k].nearest);
            if (bounds_ == MapBounds::kPixel) pixel.put_if(outside[k], furthest_, m, 0, wider[k].furthest);
        }
        return true;
    }

    // Those of the samples that the fragment covers.
    template <class D, class P>
    void fetch(const FragmentInput<D>& f, P& pixel) const {
        if (bounds_ == MapBounds::kFrame) return;
        for (int m = 0; m < samples_; ++m) pixel.fetch_if(bit(f.coverage, m), nearest_, m);
    }
    template <class D, class P>
    Range<D> load(P& pixel, int m) const {
        if (bounds_ == MapBounds::kFrame) return {0.0f, 1.0f};
        if (bounds_ == MapBounds::kNearest) return {pixel.load(nearest_, m), 0.0f};
        return {pixel.load(nearest_, m), pixel.load(furthest_, m)};
    }

    // Where depth z stands between the bounds: 0 at the nearest, 1 at the furthest, in [0, 1]. A range
    // without extent has everything at 0.
    template <class D>
    typename D::Real share(const typename D::Real& z, const Range<D>& range) const {
        using Real = typename D::Real;
        if (bounds_ == MapBounds::kFrame) return z;
        const Real behind = z - range.nearest;
        if (bounds_ == MapBounds::kNearest) return in_unit_range<D>(behind * Real(inverse_));
        const Real extent = range.furthest - range.nearest;
        // Not by the reciprocal: that of a subnormal extent is infinite.
        return in_unit_range<D>(behind / select(Real(0.0f) < extent, extent, Real(1.0f)));
    }

 private:
    // Outside of every depth; formats without such numbers clear to the ends of their range.
    static constexpr float kNone = 1e30f;

    template <class D>
    static typename D::Real in_unit_range(const typename D::Real& x) {
        using Real = typename D::Real;
        return maximum(minimum(x, Real(1.0f)), Real(0.0f));
    }

    MapBounds bounds_ = MapBounds::kFrame;
    int samples_ = 1;
    float inverse_ = 1.0f;
    Field nearest_;
    Field furthest_;
};

}  // namespace ropsim
