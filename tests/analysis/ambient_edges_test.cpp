// Which fragments of cut-outs are whole, at an edge or hidden, and what their quads say about alpha.
#include "analysis/ambient_edges.h"

#include "tests/analysis/ambient_view_of.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr int kSide = 64;
constexpr float kOpaque = 0.8f;
constexpr float kLeaf = 0.5f;

// A leaf's fragment with the luminance that `light` says.
Fragment leaf(int x, int y, float a, std::uint32_t primitive = 0, float z = kLeaf, float light = 0.5f) {
    const float c = light * a;
    return {z, c, c, c, a, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), primitive, 1, 0};
}

class AmbientEdges : public ScratchTest {
 protected:
    // Reads the fragments over an opaque plane, infers with an ambient buffer that is 0.25 left of column 32
    // and 0.75 right of it.
    void infer(const std::vector<Fragment>& fragments, HelperLanes helpers = HelperLanes::kTwin,
               bool on = true) {
        TraceHeader header = header_of(kSide, kSide, from_above(4, 4));
        header.draws.resize(2);
        header.opaque.emplace();
        header.opaque->rgb.assign(std::size_t{3} * kSide * kSide, 1.0f);
        header.opaque->depth.assign(std::size_t{kSide} * kSide, kOpaque);
        write_trace(path("leaf"), header, fragments);
        TraceReader trace(path("leaf"));
        CutoutSettings settings;
        settings.solid = {true, false};
        cutouts_ = read_cutouts(trace, settings);
        ambient_.assign(fragments.size(), 1.0f);
        std::vector<float> buffer;
        for (int i = 0; i < kSide * kSide; ++i) buffer.push_back(i % kSide < 32 ? 0.25f : 0.75f);
        const AmbientView view(header, "leaf");
        const InferenceSettings inference_settings;
        const AmbientInference inference(cutouts_.depth, buffer, view, inference_settings);
        counts_ = infer_ambient(cutouts_, settings, helpers, inference, buffer, on, 2, ambient_);
    }
    AmbientKind kind(std::size_t arrival) const {
        for (const CutoutFragment& f : cutouts_.fragments)
            if (f.arrival == arrival) return f.kind;
        return AmbientKind::kOther;
    }

    Cutouts cutouts_;
    InferenceCounts counts_;
    std::vector<float> ambient_;
};

TEST_F(AmbientEdges, KindsFollowAlphaAndDepth) {
    const std::vector<Fragment> fragments = {
        leaf(10, 10, 1),                // whole, the nearest
        leaf(11, 10, 0.5f),             // its edge
        leaf(10, 11, 0.9985f),          // nearly whole
        leaf(10, 10, 1, 4, 0.6f),       // whole, behind the first
        leaf(10, 10, 0.5f, 6, 0.6f),    // an edge behind it
        leaf(10, 10, 0.5f, 8, 0.4f),    // before it
        leaf(20, 20, 1, 10, 0.9f),      // behind the opaque layer
        leaf(22, 20, 1, 12, kOpaque),   // as deep: not less
        leaf(30, 30, 0),                // clear
        leaf(10, 10, 1, 14, kLeaf),     // as near as the first
        leaf(10, 10, 0.5f, 16, kLeaf),  // an edge as near: not less
    };
    infer(fragments);
    using Kind = AmbientKind;
    const std::array<Kind, 11> expected = {Kind::kSolid,  Kind::kLine,  Kind::kLine,   Kind::kHidden,
                                           Kind::kHidden, Kind::kLine,  Kind::kHidden, Kind::kHidden,
                                           Kind::kOther,  Kind::kSolid, Kind::kHidden};
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(kind(i), expected.at(i)) << i;
    EXPECT_EQ(cutouts_.depth.depth[cutouts_.depth.index(10, 10)], kLeaf);
    EXPECT_EQ(cutouts_.depth.depth[cutouts_.depth.index(11, 10)], kOpaque);
    EXPECT_EQ(ambient_[0], 0.25f);
    EXPECT_EQ(ambient_[8], 1.0f);
    EXPECT_EQ(ambient_[3], 1.0f);
}

// A quad whose alpha rises to the left: taps go left, where the ambient buffer has 0.25.
TEST_F(AmbientEdges, GradientsAreDifferencesWithinTheQuad) {
    const auto at_column = [&](float left, float right) {
        infer({leaf(32, 20, left), leaf(33, 20, right), leaf(32, 21, left), leaf(33, 21, right)});
        return ambient_;
    };
    for (const float a : at_column(0.8f, 0.2f))
        EXPECT_LT(a, 0.4f) << "two of twelve taps read columns 32, 33";
    for (const float a : at_column(0.2f, 0.8f)) EXPECT_EQ(a, 0.75f);
    EXPECT_EQ(counts_.taps, 4u * 12u);
    EXPECT_EQ(counts_.lanes_own, 8u);
    EXPECT_EQ(counts_.lanes_absent, 0u);
    // Flat: the square.
    at_column(0.5f, 0.5f);
    EXPECT_EQ(kind(0), AmbientKind::kBox);
    EXPECT_EQ(counts_.taps, 4u * 49u);
    at_column(0.5f, 0.50009f);
    EXPECT_EQ(kind(0), AmbientKind::kBox);
    at_column(0.5f, 0.50011f);
    EXPECT_EQ(kind(0), AmbientKind::kLine);
    // Columns 31 and 32 are no quad.
    infer({leaf(31, 20, 0.2f), leaf(32, 20, 0.8f)}, HelperLanes::kOwn);
    EXPECT_EQ(kind(0), AmbientKind::kBox);
}

TEST_F(AmbientEdges, LanesThatThePrimitiveDoesNotCover) {
    // The other triangle of the card has the left column.
    const std::vector<Fragment> card = {leaf(32, 20, 0.9f, 1), leaf(32, 21, 0.9f, 1), leaf(33, 20, 0.5f, 0),
                                        leaf(33, 21, 0.5f, 0)};
    infer(card);
    EXPECT_LT(ambient_[2], 0.4f) << "up to the left";
    EXPECT_EQ(counts_.lanes_twin, 4u);
    EXPECT_EQ(counts_.lanes_own, 4u);
    infer(card, HelperLanes::kZero);
    EXPECT_EQ(ambient_[2], 0.75f) << "0 on the left";
    infer(card, HelperLanes::kOwn);
    EXPECT_EQ(kind(2), AmbientKind::kBox);
    // Triangles 1 and 2 are no pair.
    infer({leaf(32, 20, 0.9f, 1), leaf(32, 21, 0.9f, 1), leaf(33, 20, 0.5f, 2), leaf(33, 21, 0.5f, 2)});
    EXPECT_EQ(counts_.lanes_twin, 0u);
    EXPECT_EQ(counts_.lanes_absent, 4u);
    EXPECT_EQ(ambient_[2], 0.75f);
    // The bit of the face is no part of the number.
    infer({leaf(32, 20, 0.9f, 1 | kBackFacing), leaf(33, 20, 0.5f, 0 | kBackFacing)});
    EXPECT_EQ(counts_.lanes_twin, 2u);
}

TEST_F(AmbientEdges, TexelsAreCountedOnce) {
    // Alpha rises to the right: one fragment reads columns 32, 35, ..., 62 and the border, 63, the other 33,
    // 36,
    // ..., 63 and the border again.
    const std::vector<Fragment> two = {leaf(32, 20, 0.2f), leaf(33, 20, 0.8f)};
    infer(two, HelperLanes::kOwn);
    EXPECT_EQ(counts_.taps, 24u);
    EXPECT_EQ(counts_.lanes_absent, 2u);
    EXPECT_EQ(counts_.texels, 12u + 11u - 1u);
    infer({two[0], two[1], leaf(32, 20, 0.2f, 8), leaf(33, 20, 0.8f, 8)}, HelperLanes::kOwn);
    EXPECT_EQ(counts_.taps, 48u);
    EXPECT_EQ(counts_.texels, 12u + 11u - 1u);
    infer({leaf(32, 20, 0.2f)}, HelperLanes::kOwn);
    EXPECT_EQ(counts_.texels, 49u);
    infer({leaf(32, 20, 0.2f)}, HelperLanes::kOwn, false);
    EXPECT_EQ(counts_.texels, 0u);
    EXPECT_EQ(counts_.taps, 0u);
    EXPECT_EQ(ambient_[0], 1.0f);
}

TEST_F(AmbientEdges, TheStepOfAnOutlineByHand) {
    // Whole in column 32, its edge in 33, equally bright; the edge sees AO 0.75 as the whole does.
    infer({leaf(32, 20, 1), leaf(33, 20, 0.5f), leaf(32, 21, 1), leaf(33, 21, 0.5f)});
    EdgeStep step = edge_step(cutouts_, ambient_, 0.4);
    EXPECT_EQ(step.pairs, 4u);
    EXPECT_NEAR(step.without.value(), 0, 1e-6);
    EXPECT_NEAR(step.solid_only.value(), 1 / 0.9 - 1, 1e-6);
    const double edge = static_cast<double>(ambient_[1]);
    EXPECT_NEAR(step.inferred.value(), (1 - 0.4 * (1 - edge)) / 0.9 - 1, 1e-6);
    EXPECT_NEAR(step.difference_solid_only, 0.25, 1e-6);
    EXPECT_NEAR(step.difference_inferred, std::abs(edge - 0.75), 1e-6);
    // An edge of another primitive, a hidden one, and one in another quad make no pair.
    infer({leaf(32, 20, 1), leaf(33, 20, 0.5f, 2), leaf(32, 21, 0.5f, 0, 0.9f), leaf(34, 20, 0.5f)});
    EXPECT_EQ(edge_step(cutouts_, ambient_, 0.4).pairs, 0u);
    // A darker edge.
    infer({leaf(32, 20, 1, 0, kLeaf, 0.8f), leaf(33, 20, 0.5f, 0, kLeaf, 0.6f)});
    EXPECT_NEAR(edge_step(cutouts_, ambient_, 0.4).without.value(), -0.25, 1e-6);
}

}  // namespace
}  // namespace ropsim
