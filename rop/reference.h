// Exact compositing in double precision: the image every technique is compared with.
#pragma once

#include "rop/declaration.h"
#include "traces/image.h"
#include "traces/trace.h"

#include <cstdint>

namespace ropsim {

// What a fragment lets through of what is behind it.
enum class Transmission : std::uint8_t {
    kAlpha,    // 1 - alpha, in every channel; of fragments that transmit, the least alpha that means the same
    kColored,  // 1 - alpha + alpha * t of its Material, per channel: equation 1 of McGuire and Mara 2017.
               // Without materials t is 0 and the image that of kAlpha, bit for bit.
};

inline constexpr std::uint64_t kReferenceBandFragments = 4u << 20;

// Channels R, G, B, A (total of the alphas that are composited), "layers" (visible fragments of the pixel),
// "ties" (pairs of neighbours in depth order with equal depth). Each pixel's fragments that pass the opaque
// depth test are sorted by depth, of equal depths the earlier arrival nearer, and composited front to back
// over the opaque layer. With M > 1 spatial samples each sample is composited alone, with the depths that
// fragments have there and its own opaque colour and depth, and the M results are averaged, or with another
// display filter weighted over the samples of the neighbours too, which keeps all samples in memory. Memory
// is otherwise bounded by working on bands of tiles with at most `band_fragments` fragments (about 36 bytes
// each, with coloured transmission 48; a single tile may hold more). The trace is left rewound with all tiles
// selected.
Image reference_image(TraceReader& trace, int threads, DisplayFilter filter = DisplayFilter::kBox,
                      std::uint64_t band_fragments = kReferenceBandFragments,
                      Transmission transmission = Transmission::kAlpha);

// The same, kept in the user's cache directory (XDG_CACHE_HOME or ~/.cache, ropsim/<hash>-v3.exr; before
// "-v3" stand "-gaussian" with that filter and "-colored" with coloured transmission) under the trace's hash.
// A cache that cannot be read or written is passed over.
Image cached_reference_image(TraceReader& trace, int threads, DisplayFilter filter = DisplayFilter::kBox,
                             Transmission transmission = Transmission::kAlpha);

}  // namespace ropsim
