// Intel's one-pass AOIT: the published code replayed, fragment by fragment.
#include "tests/rop/layer_lists.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// A pixel of the published code: transmittances in 0..255, float while a fragment is inserted. Where two
// nodes are merged it multiplies by a reciprocal, which is not exact, and no shading language says to the
// last bit what comes out: a colour half-way between two codes may become either. Here it becomes what is
// stored.
class PublishedPixel {
 public:
    explicit PublishedPixel(int nodes) : count_(static_cast<std::size_t>(nodes)) {}
    // False once a reciprocal of 0 has made a node's colour NaN and black.
    bool draw(const Fragment& f) {
        if (nodes_.empty()) {
            clear(f);
            return true;
        }
        bool divided_by_zero = false;
        merges_ = false;
        const float t = 1.0f - f.a;
        std::size_t index = 0;
        float before = 255;
        for (const Node& n : nodes_)
            if (f.z > n.z) {
                ++index;
                before = n.t;
            }
        nodes_.push_back({});
        for (std::size_t i = count_; i-- > index;) {
            nodes_[i + 1] = nodes_[i];
            nodes_[i + 1].t *= t;
        }
        nodes_[index] = {f.z, t * before, packed({f.r, f.g, f.b})};
        if (nodes_[count_].z != kEmpty) {
            Node& near = nodes_[count_ - 1];
            divided_by_zero = nodes_[count_ - 2].t == 0.0f;
            std::array<float, 3> rgb{};
            for (std::size_t c = 0; c < 3; ++c) {
                rgb[c] = static_cast<float>(near.rgb[c]) / 255 + static_cast<float>(nodes_[count_].rgb[c]) /
                                                                     255 * near.t *
                                                                     (1.0f / nodes_[count_ - 2].t);
                merged_[c] = static_cast<double>(near.rgb[c]) + static_cast<double>(nodes_[count_].rgb[c]) *
                                                                    static_cast<double>(near.t) /
                                                                    static_cast<double>(nodes_[count_ - 2].t);
            }
            near.rgb = packed(rgb);
            merges_ = true;
            near.t = nodes_[count_].t;
        }
        nodes_.pop_back();
        for (Node& n : nodes_) n.t = std::floor(n.t);
        return !divided_by_zero;
    }
    void expect_stored(TestFrame& frame, int step) {
        const auto n = static_cast<int>(count_);
        for (int i = 0; i < n; ++i) {
            Node& node = nodes_[static_cast<std::size_t>(i)];
            ASSERT_EQ(std::lround(255 * test::stored_real(frame, 4 * n + i)), std::lround(node.t))
                << "fragment " << step << " node " << i;
            if (node.z == kEmpty) continue;
            ASSERT_EQ(test::stored_real(frame, i), node.z);
            for (int c = 0; c < 3; ++c) {
                const auto stored =
                    static_cast<int>(std::lround(255 * test::stored_real(frame, n + 3 * i + c)));
                int& code = node.rgb[static_cast<std::size_t>(c)];
                if (i == n - 1 && stored != code && is_half_way(static_cast<std::size_t>(c), stored, code)) {
                    ++half_way_;
                    code = stored;
                }
                ASSERT_EQ(stored, code) << "fragment " << step << " node " << i;
            }
        }
    }
    int half_way() const { return half_way_; }

 private:
    static constexpr float kEmpty = 3.40282e38f;
    struct Node {
        float z = 0;
        float t = 0;
        std::array<int, 3> rgb{};
    };
    static std::array<int, 3> packed(std::array<float, 3> rgb) {
        std::array<int, 3> out{};
        // NaN is not greater than 0: HLSL's saturate.
        for (std::size_t c = 0; c < 3; ++c)
            out[c] = static_cast<int>((rgb[c] > 0 ? std::min(rgb[c], 1.0f) : 0.0f) * 255.0f + 0.5f);
        return out;
    }
    // Between the two codes, as near as six roundings of float32 to values below 256 tell.
    bool is_half_way(std::size_t c, int a, int b) const {
        return merges_ && std::abs(a - b) == 1 && std::abs(merged_[c] - 0.5 * (a + b)) < 6 * 0x1p-16;
    }
    void clear(const Fragment& f) {
        merges_ = false;
        nodes_.assign(count_, {kEmpty, std::floor((1.0f - f.a) * 255.0f + 0.5f), {}});
        nodes_[0].z = f.z;
        nodes_[0].rgb = packed({f.r, f.g, f.b});
    }

    std::size_t count_;
    std::vector<Node> nodes_;
    std::array<double, 3> merged_{};  // codes of the last merge, before they are rounded
    bool merges_ = false;
    int half_way_ = 0;
};

// Of 300,000 random fragments about 350 colours are half-way between codes and differ by one: the quotient of
// transmittances is exact there, as of halves, and the reciprocal a bit below.
TEST(Aoit, StoresWhatThePublishedCodeStores) {
    int compared = 0;
    int half_way = 0;
    for (const int nodes : {2, 4, 8})
        for (std::uint64_t seed = 0; seed < 4000; ++seed) {
            Random random(1000 + seed);
            PublishedPixel published(nodes);
            TestFrame frame("aoit:nodes=" + std::to_string(nodes), test::header_of(1, 1));
            for (int i = 0; i < 30; ++i) {
                // Halves and quarters too: their products are whole counts.
                const float a =
                    i % 3 == 0 ? static_cast<float>(random.integer(0, 3)) / 4 : random.real(0, 0.9);
                const std::array<float, 3> color{random.real(0, 1), random.real(0, 1), random.real(0, 1)};
                const float z = random.real(0, 1);
                const Fragment f = test::fragment_at(0, 0, z, a, color);
                if (!published.draw(f)) break;
                frame.draw_one(f);
                ++compared;
                ASSERT_NO_FATAL_FAILURE(published.expect_stored(frame, i))
                    << nodes << " nodes, seed " << seed;
            }
            half_way += published.half_way();
        }
    EXPECT_GT(compared, 200'000);
    EXPECT_GT(half_way, 0);
    EXPECT_LT(half_way, compared / 500);
}

}  // namespace
}  // namespace ropsim
