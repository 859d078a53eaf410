// Techniques of the software path that work on lists of fragments: the choices that they share with the model
// agree.
#include "tests/cli/cli_driver.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

class ValidateListsCli : public Cli {
 protected:
    // Each technique as its paper stores it and in float32; all must hold, over about as many pixels as there
    // are.
    void expect_agreement(const RandomFragments& options, const std::vector<std::string>& techniques) const {
        TraceWriter writer(path("random.trace"), random_header(options));
        writer.append(random_chunk(options));
        writer.finish();
        Arguments arguments = {"validate", path("random.trace"), "--json", "--seed", "99", "-o", path("out")};
        for (const std::string& technique : techniques)
            for (const char* format : {"paper", "float32"})
                arguments.insert(arguments.end(),
                                 {"--technique",
                                  fmt::format("{}{}format={}", technique,
                                              technique.find(':') == std::string::npos ? ':' : ',', format)});
        const auto json = expect_json(arguments);
        ASSERT_EQ(json["techniques"].size(), 2 * techniques.size());
        for (const auto& t : json["techniques"]) {
            EXPECT_TRUE(t["holds"].get<bool>()) << t["technique"];
            EXPECT_GT(t["pixels"].get<int>(), 600) << t["technique"];
        }
    }
    static RandomFragments shuffled() {
        RandomFragments options;
        options.count = 20000;
        options.width = 40;
        options.height = 24;
        options.opaque = true;
        options.draws = 3;
        options.depth_levels = 50;
        return options;
    }
};

TEST_F(ValidateListsCli, CurvesAgree) {
    expect_agreement(shuffled(), {"adaptive:nodes=2", "adaptive:nodes=5,removal=overestimate",
                                  "adaptive:nodes=8,removal=node_by_node,composite=normalised",
                                  "adaptive:nodes=8,candidates=protect_front_half",
                                  "adaptive:nodes=4,candidates=protect_furthest,transmittance_format=unorm8",
                                  "adaptive:nodes=8,memory=variable"});
}

TEST_F(ValidateListsCli, LayersAgree) {
    expect_agreement(
        shuffled(),
        {"k_buffer:layers=1", "hybrid:layers=3", "hybrid:layers=5,tail_factor=off,tail_format=float16",
         "slab:layers=3,bits=5", "slab:layers=4,bits=inf", "slab:probability=non_stratified",
         "slab:composite=accumulated", "slab:composite=normalised,bits=40", "mlab:layers=3",
         "mlab:layers=1,ties=oldest", "depth_peeling:layers=5"});
}

TEST_F(ValidateListsCli, MapsAndMomentsAgree) {
    expect_agreement(shuffled(),
                     {"fourier_map:composite=normalised,guard=.1", "fourier_map:coefficients=15,clamp=off",
                      "fourier_map:memory=variable,bounds=frame", "opacity_map:slices=5,lookup=step",
                      "opacity_map:composite=normalised", "opacity_map:memory=variable", "moment_based"});
}

TEST_F(ValidateListsCli, StoredSamplesAgree) {
    expect_agreement(shuffled(), {"laine_karras:samples=5,index=morton", "laine_karras:tracking=false",
                                  "laine_karras:compaction=false", "laine_karras:sort=false,samples=40",
                                  "laine_karras:method=depth_based"});
}

TEST_F(ValidateListsCli, SpatialSamplesAgree) {
    RandomFragments options = shuffled();
    options.samples = 4;
    options.partial_coverage = true;
    options.slopes = true;
    expect_agreement(options, {"a_buffer", "adaptive:nodes=6", "adaptive:nodes=6,memory=variable",
                               "fourier_map", "fourier_map:memory=variable", "opacity_map:slices=8",
                               "laine_karras:samples=8", "depth_peeling"});
}

TEST_F(ValidateListsCli, OtherKeysAreRefused) {
    const std::string out = path("out");
    expect_refused({"validate", path("trace"), "--technique", "mlab:merge=closest", "-o", out}, {"merge"});
    expect_refused({"validate", path("trace"), "--technique", "k_buffer:depth_format=unorm8", "-o", out},
                   {"depth_format", "float32"});
    expect_refused({"validate", path("trace"), "--technique", "fourier_map:coefficients=4", "-o", out},
                   {"coefficients", "odd"});
}

}  // namespace
}  // namespace ropsim
