#include "analysis/ambient_cutouts.h"

#include "base/error.h"
#include "traces/depth_test.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace ropsim {

namespace {

bool before(const CutoutFragment& a, const CutoutFragment& b) {
    if (a.quad() != b.quad()) return a.quad() < b.quad();
    return std::tuple(a.primitive, a.y, a.x, a.z, a.a, a.luminance) <
           std::tuple(b.primitive, b.y, b.x, b.z, b.a, b.luminance);
}

CutoutFragment cutout(const Fragment& f, bool in_front, std::uint64_t arrival) {
    const float light = 0.2126f * f.r + 0.7152f * f.g + 0.0722f * f.b;
    return {primitive_number(f),
            f.draw,
            f.x,
            f.y,
            in_front,
            AmbientKind::kHidden,
            f.z,
            f.a,
            f.a > 0 ? light / f.a : 0.0f,
            static_cast<std::uint32_t>(arrival)};
}

// The opaque layer's alone.
DepthBuffer opaque_depth(const TraceHeader& header) {
    DepthBuffer depth{header.width, header.height, {}};
    if (header.opaque)
        depth.depth = header.opaque->depth;
    else
        depth.depth.assign(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height),
                           std::numeric_limits<float>::infinity());
    return depth;
}

}  // namespace

Cutouts read_cutouts(TraceReader& trace, const CutoutSettings& settings) {
    const TraceHeader& header = trace.header();
    CHECK(header.samples == 1 && settings.solid.size() == header.draws.size(), "{} samples, {} draws",
          header.samples, header.draws.size());
    if (trace.fragment_count() >= std::uint64_t{1} << 32)
        throw UserError(trace.path(),
                        fmt::format("holds {} fragments; up to 2^32 - 1 can be taken; cut it with "
                                    "'trace cut'",
                                    trace.fragment_count()));
    Cutouts result;
    result.depth = opaque_depth(header);
    const OpaqueDepthTest test(header);
    FragmentChunk chunk;
    trace.rewind();
    while (trace.next(chunk, kNoChannels)) {
        for (const Fragment& f : chunk.fragments) {
            const std::uint64_t arrival = result.trace_fragments++;
            if (!settings.solid[f.draw]) continue;
            const bool in_front = test.visible_samples(f, DepthSlope{}) != 0;
            result.fragments.push_back(cutout(f, in_front, arrival));
            if (!in_front || f.a < settings.solid_alpha) continue;
            float& nearest = result.depth.depth[result.depth.index(f.x, f.y)];
            nearest = std::min(nearest, f.z);
        }
    }
    trace.rewind();
    std::sort(result.fragments.begin(), result.fragments.end(), before);
    return result;
}

}  // namespace ropsim
