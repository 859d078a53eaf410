// Walks a captured trace's receivers, opaque samples and transparent fragments, hands each to a caster, and
// writes the trace twice: with the shadow as looked up, and with the exact one.
#pragma once

#include "base/parallel.h"
#include "base/random.h"
#include "rop/shadow/light_space.h"
#include "traces/depth_test.h"
#include "traces/trace.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace ropsim {

// What receives the shadow: a sample of the opaque layer, or a fragment.
struct ShadowReceiver {
    bool opaque = false;
    std::size_t sample = 0;              // of the opaque layer's depths
    const Material* material = nullptr;  // of a fragment, where the trace has materials
};

namespace shadow_traversal {

inline constexpr std::size_t kPiece = 2048;                 // look-ups that a thread does at a time
inline constexpr std::size_t kBand = std::size_t{1} << 18;  // of the opaque layer, kept until counted

template <typename Work>
void for_each_in_parallel(int threads, std::size_t count, const Work& work) {
    const auto pieces = static_cast<int>((count + kPiece - 1) / kPiece);
    parallel_for(threads, pieces, [&](int piece) {
        const std::size_t first = static_cast<std::size_t>(piece) * kPiece;
        for (std::size_t i = first; i < std::min(count, first + kPiece); ++i) work(i);
    });
}

inline void dim(float& r, float& g, float& b, const glm::vec3& light) {
    r *= light.r;
    g *= light.g;
    b *= light.b;
}

// Dims the opaque layers of both headers, which start as copies of the camera's.
template <typename Caster>
void shadow_opaque(Caster& caster, TraceHeader& shadowed, TraceHeader& exact, int threads) {
    if (!shadowed.opaque) return;
    const auto samples = static_cast<std::size_t>(shadowed.samples);
    const auto width = static_cast<std::size_t>(shadowed.width);
    const std::vector<float>& depth = shadowed.opaque->depth;
    const auto positions = sample_positions(shadowed.samples);
    std::vector<typename Caster::Seen> seen;
    for (std::size_t first = 0; first < depth.size(); first += kBand) {
        seen.assign(std::min(kBand, depth.size() - first), {});
        for_each_in_parallel(threads, seen.size(), [&](std::size_t i) {
            const std::size_t at = first + i;
            if (!std::isfinite(depth[at])) return;
            const SamplePosition position = positions[at % samples];
            const std::size_t row = at / samples / width;
            const std::size_t column = at / samples % width;
            const ViewPoint point{static_cast<double>(column) + 0.5 + static_cast<double>(position.x()),
                                  static_cast<double>(row) + 0.5 + static_cast<double>(position.y()),
                                  static_cast<double>(depth[at])};
            seen[i] = caster.look_up(point, mix64(caster.seed() ^ ~std::uint64_t{at}), {true, at, nullptr});
            for (const auto& [layer, light] : {std::pair(&shadowed.opaque->rgb, caster.light(seen[i])),
                                               {&exact.opaque->rgb, caster.exact_light(seen[i])}})
                dim((*layer)[3 * at], (*layer)[3 * at + 1], (*layer)[3 * at + 2], light);
        });
        caster.count(seen, true);
    }
}

}  // namespace shadow_traversal

// A Caster has a Seen, default-constructed for what was not looked up;
//   Seen look_up(const ViewPoint& point, std::uint64_t key, const ShadowReceiver&) const   thread-safe
//   glm::vec3 light(const Seen&), exact_light(const Seen&) const   what colours are multiplied by
//   void count(const std::vector<Seen>&, bool opaque)              in the order of the look-ups
//   std::uint64_t seed() const, int threads() const.
// `camera` is left rewound. Throws UserError on a damaged trace or a file that cannot be written.
template <typename Caster>
void cast_shadows_on(TraceReader& camera, Caster& caster, const std::string& shadowed,
                     const std::string& exact) {
    const TraceHeader& header = camera.header();
    TraceHeader shadowed_header = header;
    shadowed_header.non_finite = false;
    TraceHeader exact_header = shadowed_header;
    shadow_traversal::shadow_opaque(caster, shadowed_header, exact_header, caster.threads());
    TraceWriter shadowed_writer(shadowed, std::move(shadowed_header));
    TraceWriter exact_writer(exact, std::move(exact_header));
    const OpaqueDepthTest test(header);
    FragmentChunk chunk;
    FragmentChunk exact_chunk;
    std::vector<typename Caster::Seen> seen;
    camera.rewind();
    while (camera.next(chunk)) {
        exact_chunk = chunk;
        seen.assign(chunk.size(), {});
        shadow_traversal::for_each_in_parallel(caster.threads(), chunk.size(), [&](std::size_t i) {
            Fragment& f = chunk.fragments[i];
            if (test.visible_samples(f, chunk.slopes.empty() ? DepthSlope{} : chunk.slopes[i]) == 0) return;
            const std::uint64_t pixel =
                static_cast<std::uint64_t>(f.y) * static_cast<std::uint64_t>(header.width) + f.x;
            const std::uint64_t key =
                mix64(mix64(caster.seed() + f.draw) ^ (pixel << 32) ^ primitive_number(f));
            seen[i] = caster.look_up({f.x + 0.5, f.y + 0.5, static_cast<double>(f.z)}, key,
                                     {false, 0, chunk.materials.empty() ? nullptr : &chunk.materials[i]});
            shadow_traversal::dim(f.r, f.g, f.b, caster.light(seen[i]));
            Fragment& e = exact_chunk.fragments[i];
            shadow_traversal::dim(e.r, e.g, e.b, caster.exact_light(seen[i]));
        });
        caster.count(seen, false);
        shadowed_writer.append(chunk);
        exact_writer.append(exact_chunk);
    }
    camera.rewind();
    shadowed_writer.finish();
    exact_writer.finish();
}

}  // namespace ropsim
