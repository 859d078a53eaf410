// Fragments at the far plane, where a depth of few bits has its clear value: they keep their place in every
// list of nodes or layers.
#include "tests/rop/random_fragments.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::fragment_at;
using test::TestFrame;

class FarPlane : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Lists, FarPlane,
                         testing::Values("adaptive:nodes=4", "slab:layers=4,bits=inf", "k_buffer:layers=4",
                                         "k_plus_buffer:layers=4", "hybrid:layers=4", "mlab:layers=4",
                                         "mlab:layers=4,ties=oldest", "aoit:nodes=4", "z3:fragments=4"),
                         [](const auto& setup) {
                             std::string name = setup.param;
                             std::ranges::replace_if(
                                 name, [](char c) { return std::isalnum(c) == 0; }, '_');
                             return name;
                         });

// Three layers, the last at depth 1, in every order of arrival.
TEST_P(FarPlane, KeepsItsPlaceInEveryOrder) {
    for (const char* format : {"unorm16", "unorm24", "float16", "log8"}) {
        std::vector<Fragment> fragments = {fragment_at(0, 0, 0.25f, 0.5f, {1, 0, 0}, 0),
                                           fragment_at(0, 0, 0.5f, 0.5f, {0, 1, 0}, 1),
                                           fragment_at(0, 0, 1.0f, 0.5f, {0, 0, 1}, 2)};
        std::vector<int> order = {0, 1, 2};
        do {
            std::vector<Fragment> arrival;
            for (const int i : order) arrival.push_back(fragments[static_cast<std::size_t>(i)]);
            TestFrame frame(GetParam() + ",depth_format=" + format, test::header_of(1, 1, 1, {1, 1, 1}));
            frame.draw(arrival);
            const auto exact = test::composited(fragments, 0, 0, {1, 1, 1});
            const auto color = frame.color();
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(color[c], exact[c], 4.0 / 255)
                    << format << " order " << order[0] << order[1] << order[2] << " channel " << c;
        } while (std::next_permutation(order.begin(), order.end()));
    }
}

}  // namespace
}  // namespace ropsim
