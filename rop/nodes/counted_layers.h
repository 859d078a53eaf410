// A pixel's k nearest fragments as sorted layers, and how many there are: the k-buffer's state and operation.
#pragma once

#include "rop/nodes/stored_layers.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <cstdint>

namespace ropsim {

class CountedLayers {
 public:
    enum Outcome { kAppended, kReplaced, kDropped };

    CountedLayers() = default;
    // Declares surfaces layers and count, of that resolution (Surface::scale).
    CountedLayers(Declaration& declaration, const TechniqueFormats& formats, int layers, int scale = 1)
        : layers_(declaration, formats, layers, {}) {
        declaration.surfaces.back().scale = scale;
        count_ = declaration.surface("count", 1, Layout::kInterleaved, Initial::kClear,
                                     {FieldSpec::integer(32, 0)}, scale)[0];
    }
    const StoredLayers& layers() const { return layers_; }

    // Of a full list the furthest of the k + 1 is dropped. Of equal depths the earlier arrival is nearer.
    template <class D, class P>
    Outcome insert(D& d, const typename D::Real& z, const Rgb<D>& premultiplied,
                   const typename D::Real& alpha, P& pixel) const {
        using Uint = typename D::Uint;
        pixel.fetch_all(count_, 1);
        layers_.fetch(pixel);
        const Uint count = pixel.load_bits(count_);
        const auto front = layers_.in_front<D>(pixel, z, EqualDepth::kFragmentBehind);
        const auto full = count == Uint(static_cast<std::uint32_t>(layers_.layers()));
        const auto incoming = layers_.converted<D>(pixel, z, premultiplied, alpha, {0u, 0u});
        if (!d.decide(full)) {
            layers_.insert<D>(pixel, front, incoming);
            pixel.write(count_);
            pixel.put_bits(count_, 0, 0, count + Uint(1u));
            return kAppended;
        }
        if (d.decide(layers_.all<D>(front))) return kDropped;
        layers_.insert<D>(pixel, front, incoming);
        return kReplaced;
    }

 private:
    StoredLayers layers_;
    Field count_;
};

}  // namespace ropsim
