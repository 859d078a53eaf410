#include "analysis/ambient_edges.h"

#include "base/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

namespace ropsim {

namespace {

constexpr std::size_t kPieceQuads = 1024;  // that a thread does at a time
constexpr double kFaint = 0.01;            // Listing 2's least divisor
constexpr double kMatch = 0.5;             // weight of a tap on the fragment's own surface, or near it

using Quad = std::span<CutoutFragment>;

// Where each quad's fragments begin, and the end.
std::vector<std::size_t> quad_starts(const std::vector<CutoutFragment>& fragments) {
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < fragments.size(); ++i)
        if (i == 0 || fragments[i - 1].quad() != fragments[i].quad()) starts.push_back(i);
    starts.push_back(fragments.size());
    return starts;
}

// Alpha that `primitive` has at a pixel of the quad; of several fragments the nearest's.
std::optional<float> alpha_at(Quad quad, std::uint32_t primitive, int x, int y) {
    for (const CutoutFragment& f : quad)
        if (f.primitive == primitive && f.x == x && f.y == y) return f.a;
    return std::nullopt;
}

struct EdgePass {
    const CutoutSettings& settings;
    HelperLanes helpers;
    const DepthBuffer& depth;
    const AmbientInference& inference;
    std::span<const float> buffer;
    bool infer;
    std::vector<float>& ambient;
    std::vector<std::uint8_t>& read;  // texels that a tap has read, by any thread

    void quad(Quad quad, InferenceCounts& counts) const {
        for (CutoutFragment& f : quad) {
            const std::size_t pixel = depth.index(f.x, f.y);
            const bool whole = f.a >= settings.solid_alpha;
            if (!f.in_front || (whole ? f.z > depth.depth[pixel] : f.z >= depth.depth[pixel])) {
                f.kind = AmbientKind::kHidden;
            } else if (whole) {
                f.kind = AmbientKind::kSolid;
                ambient[f.arrival] = buffer[pixel];
            } else if (f.a > 0) {
                edge(quad, f, counts);
            } else {
                f.kind = AmbientKind::kOther;
            }
        }
    }

    float lane(Quad quad, const CutoutFragment& f, int x, int y, InferenceCounts& counts) const {
        if (const auto own = alpha_at(quad, f.primitive, x, y)) {
            ++counts.lanes_own;
            return *own;
        }
        const auto twin = alpha_at(quad, f.primitive ^ 1u, x, y);
        ++(twin ? counts.lanes_twin : counts.lanes_absent);
        if (helpers == HelperLanes::kOwn) return f.a;
        return helpers == HelperLanes::kTwin ? twin.value_or(0.0f) : 0.0f;
    }

    void edge(Quad quad, CutoutFragment& f, InferenceCounts& counts) const {
        const double a = static_cast<double>(f.a);
        const double across = static_cast<double>(lane(quad, f, f.x ^ 1, f.y, counts)) - a;
        const double down = static_cast<double>(lane(quad, f, f.x, f.y ^ 1, counts)) - a;
        const glm::dvec2 gradient((f.x & 1) != 0 ? -across : across, (f.y & 1) != 0 ? -down : down);
        f.kind = inference.along_line(gradient) ? AmbientKind::kLine : AmbientKind::kBox;
        if (!infer) return;
        const Inferred inferred = inference.at(f.x, f.y, f.z, gradient, [this](std::size_t texel) {
            std::atomic_ref<std::uint8_t>(read[texel]).store(1, std::memory_order_relaxed);
        });
        ambient[f.arrival] = static_cast<float>(inferred.ambient);
        counts.taps += static_cast<std::uint64_t>(inferred.taps);
        counts.faint += inferred.weight < kFaint ? 1 : 0;
        counts.unmatched += inferred.best < kMatch ? 1 : 0;
    }
};

void add(const InferenceCounts& counts, InferenceCounts& to) {
    to.lanes_own += counts.lanes_own;
    to.lanes_twin += counts.lanes_twin;
    to.lanes_absent += counts.lanes_absent;
    to.taps += counts.taps;
    to.faint += counts.faint;
    to.unmatched += counts.unmatched;
}

bool at_edge(const CutoutFragment& f) {
    return f.kind == AmbientKind::kLine || f.kind == AmbientKind::kBox;
}

}  // namespace

InferenceCounts infer_ambient(Cutouts& cutouts, const CutoutSettings& settings, HelperLanes helpers,
                              const AmbientInference& inference, std::span<const float> buffer, bool infer,
                              int threads, std::vector<float>& ambient) {
    std::vector<std::uint8_t> read(cutouts.depth.depth.size());
    const EdgePass pass{settings, helpers, cutouts.depth, inference, buffer, infer, ambient, read};
    const std::vector<std::size_t> starts = quad_starts(cutouts.fragments);
    const std::size_t quads = starts.size() - 1;
    std::vector<InferenceCounts> counts((quads + kPieceQuads - 1) / kPieceQuads);
    parallel_for(threads, static_cast<int>(counts.size()), [&](int piece) {
        const auto p = static_cast<std::size_t>(piece);
        for (std::size_t q = p * kPieceQuads; q < std::min(quads, (p + 1) * kPieceQuads); ++q)
            pass.quad(Quad(&cutouts.fragments[starts[q]], starts[q + 1] - starts[q]), counts[p]);
    });
    InferenceCounts total;
    for (const InferenceCounts& piece : counts) add(piece, total);
    total.texels = static_cast<std::uint64_t>(std::count(read.begin(), read.end(), std::uint8_t{1}));
    return total;
}

EdgeStep edge_step(const Cutouts& cutouts, const std::vector<float>& ambient, double share) {
    EdgeStep step;
    double edges = 0, wholes = 0, lit_edges = 0, lit_wholes = 0;
    const auto& fragments = cutouts.fragments;
    for (std::size_t first = 0, last = 0; first < fragments.size(); first = last) {
        while (last < fragments.size() && fragments[last].quad() == fragments[first].quad()) ++last;
        for (std::size_t e = first; e < last; ++e) {
            if (!at_edge(fragments[e])) continue;
            for (std::size_t w = first; w < last; ++w) {
                if (fragments[w].kind != AmbientKind::kSolid ||
                    fragments[w].primitive != fragments[e].primitive)
                    continue;
                const double of_edge = static_cast<double>(ambient[fragments[e].arrival]);
                const double of_whole = static_cast<double>(ambient[fragments[w].arrival]);
                const double edge = static_cast<double>(fragments[e].luminance);
                const double whole = static_cast<double>(fragments[w].luminance);
                ++step.pairs;
                edges += edge;
                wholes += whole;
                lit_edges += edge * (1 - share * (1 - of_edge));
                lit_wholes += whole * (1 - share * (1 - of_whole));
                step.difference_solid_only += 1 - of_whole;
                step.difference_inferred += std::abs(of_edge - of_whole);
            }
        }
    }
    if (wholes > 0) step.without = edges / wholes - 1;
    if (lit_wholes > 0) {
        step.solid_only = edges / lit_wholes - 1;
        step.inferred = lit_edges / lit_wholes - 1;
    }
    if (step.pairs > 0) {
        step.difference_solid_only /= static_cast<double>(step.pairs);
        step.difference_inferred /= static_cast<double>(step.pairs);
    }
    return step;
}

}  // namespace ropsim
