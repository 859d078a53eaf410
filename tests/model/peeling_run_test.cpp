// Peeling through the whole program: run.json's passes and bytes, and the exact reference from a run.
#include "tests/model/machine_driver.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using PeelingRunTest = ModelTest;

// Three layers at one pixel, two at another, in different tiles.
std::vector<Fragment> few_layers() {
    std::vector<Fragment> fragments;
    std::uint32_t primitive = 0;
    for (const float z : {0.75f, 0.25f, 0.5f}) fragments.push_back(fragment_at(2, 3, z, primitive++));
    for (const float z : {0.5f, 0.125f}) fragments.push_back(fragment_at(20, 3, z, primitive++));
    return fragments;
}

TEST_F(PeelingRunTest, PassesAreThoseOverTheFragments) {
    const std::string trace = write(plain_header(32, 8), few_layers());
    const std::vector<std::string> count = {"--fidelity", "count"};
    // Three layers and a round that finds nothing; a limit; both ends: the ranges and two peels; fixed
    // passes.
    for (const auto& [technique, passes] :
         {std::pair("depth_peeling", 4), std::pair("depth_peeling:layers=2", 2),
          std::pair("dual_depth_peeling", 3), std::pair("adaptive", 2), std::pair("stochastic", 1)})
        EXPECT_EQ(run(trace, technique, {}, count)["passes"], passes) << technique;
}

// Five fragments in each of four rounds, at the worst case of 8 + 8 bytes; each of four blends reads and
// empties the layer of the 128 pixels of two tiles, and adds to their sums.
TEST_F(PeelingRunTest, WorstCaseIsTheTablesTimesThePasses) {
    const std::string trace = write(plain_header(32, 8), few_layers());
    const auto traffic = run(trace, "depth_peeling", {}, {"--fidelity", "count"})["traffic"];
    EXPECT_EQ(traffic["depth"]["worst_case_read_bytes"], 4 * 5 * 8);
    EXPECT_EQ(traffic["depth"]["worst_case_write_bytes"], 4 * 5 * 4);
    EXPECT_EQ(traffic["layer"]["worst_case_read_bytes"], 4 * 128 * 4);
    EXPECT_EQ(traffic["layer"]["worst_case_write_bytes"], 4 * 5 * 4 + 4 * 128 * 4);
    EXPECT_EQ(traffic["accumulated_color"]["worst_case_read_bytes"], (4 + 1) * 128 * 8);
    EXPECT_EQ(traffic["accumulated_color"]["worst_case_write_bytes"], 4 * 128 * 8);
    // A range pass and two peels.
    const auto dual = run(trace, "dual_depth_peeling", {}, {"--fidelity", "count"})["traffic"];
    EXPECT_EQ(dual["range"]["worst_case_read_bytes"], 5 * 8 + 2 * 5 * 16);
    EXPECT_EQ(dual["range"]["worst_case_write_bytes"], 3 * 5 * 8);
    EXPECT_EQ(dual["front_color"]["worst_case_write_bytes"], 2 * 5 * 8);
    EXPECT_EQ(dual["back_color"]["worst_case_read_bytes"], 2 * 5 * 8 + 128 * 8);
}

// A scene with opaque geometry, shared depths and several partitions: the image is the reference's, timed
// too.
TEST_F(PeelingRunTest, EqualsTheReference) {
    RandomFragments options;
    options.width = 40;
    options.height = 30;
    options.count = 9000;
    options.opaque = true;
    options.depth_levels = 400;
    const std::string trace = write(random_header(options), random_fragments(options));
    for (const char* fidelity : {"count", "timed"}) {
        const auto exact =
            run(trace, "depth_peeling:format=float32,ties=primitive", {}, {"--fidelity", fidelity});
        EXPECT_LT(exact["error"]["max_abs"], 1e-5) << fidelity;
    }
    const auto collapsed = run(trace, "depth_peeling:format=float32", {}, {"--fidelity", "count"});
    EXPECT_GT(collapsed["error"]["max_abs"], 0.05);
}

}  // namespace
}  // namespace ropsim
