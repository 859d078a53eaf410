// `ropsim validate`: model and software path agree on scenes and on traces of all kinds, and what differs is
// found.
#include "tests/cli/cli_driver.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

class ValidateCli : public Cli {
 protected:
    void write_random(const RandomFragments& options) const {
        TraceWriter writer(path("random.trace"), random_header(options));
        writer.append(random_chunk(options));
        writer.finish();
    }
    nlohmann::json validated(const Arguments& more) const {
        Arguments all = {"validate", path("random.trace"), "--json", "-o", path("out")};
        all.insert(all.end(), more.begin(), more.end());
        return expect_json(all);
    }
};

TEST_F(ValidateCli, GeometryOfASceneAgreesInAllTechniques) {
    const auto json = expect_json({"validate", "motor", "--size", "96x54", "--json", "-o", path("out")});
    EXPECT_TRUE(json["holds"].get<bool>());
    EXPECT_EQ(json["drawn"], "geometry");
    EXPECT_GT(json["covered_pixels"].get<int>(), 500);
    EXPECT_GE(json["techniques"].size(), 8u);
    for (const auto& t : json["techniques"]) {
        EXPECT_TRUE(t["holds"].get<bool>()) << t["technique"];
        EXPECT_GT(t["pixels"].get<int>(), 500) << t["technique"];
        EXPECT_TRUE(exists("out/" + t["picture"].get<std::string>()));
    }
    EXPECT_TRUE(exists("out/scene.trace"));
    EXPECT_TRUE(exists("out/validation.json"));
}

// Shuffled depths, several draws, hidden fragments, equal depths, alpha 0 and 1.
TEST_F(ValidateCli, RandomFragmentsAgree) {
    RandomFragments options;
    options.count = 20000;
    options.width = 40;
    options.height = 24;
    options.opaque = true;
    options.draws = 3;
    options.depth_levels = 50;
    options.materials = true;
    write_random(options);
    const auto json = validated({"--seed", "7"});
    EXPECT_EQ(json["drawn"], "fragments");
    EXPECT_EQ(json["pixels_of_other_fragments"], 0);
    int compared = 0;
    for (const auto& t : json["techniques"]) {
        if (t["holds"].is_null()) continue;  // refused by the model
        EXPECT_TRUE(t["holds"].get<bool>()) << t["technique"];
        ++compared;
    }
    EXPECT_GE(compared, 28);  // 15 techniques, two formats
}

TEST_F(ValidateCli, SpatialSamplesAgree) {
    RandomFragments options;
    options.count = 20000;
    options.opaque = true;
    options.samples = 4;
    options.partial_coverage = true;
    options.slopes = true;
    write_random(options);
    const auto json = validated({"--technique", "alpha_blend", "--technique", "stochastic:samples=8",
                                 "--technique", "stochastic:samples=4,masks=coin,format=float32"});
    EXPECT_EQ(json["techniques"].size(), 3u);
    EXPECT_TRUE(json["holds"].get<bool>());
}

TEST_F(ValidateCli, MasksAndCorrectionsAgree) {
    RandomFragments options;
    options.count = 20000;
    options.opaque = true;
    options.draws = 2;
    write_random(options);
    Arguments techniques;
    for (const char* keys : {"masks=coin", "masks=run,samples=5", "masks=alpha_to_coverage",
                             "rounding=dither,seed_from=object", "seed_from=object_facing",
                             "seed_from=depth,samples=64", "correction=coverage", "method=depth_based",
                             "method=depth_based,correction=coverage", "method=depth_based,correction=none"})
        for (const char* format : {"paper", "float32"})
            techniques.insert(techniques.end(),
                              {"--technique", fmt::format("stochastic:{},format={}", keys, format)});
    techniques.insert(techniques.end(), {"--seed", "123456789012345678"});
    EXPECT_EQ(validated(techniques)["techniques"].size(), 20u);
}

// What cannot be compared is refused before anything is drawn.
TEST_F(ValidateCli, TechniquesThatTheModelRefusesAreRefused) {
    RandomFragments options;
    options.count = 500;
    options.samples = 4;
    write_random(options);
    expect_refused({"validate", path("random.trace"), "--technique", "alpha_blend", "--technique",
                    "stochastic:samples=5", "-o", path("out")},
                   {"stochastic:samples=5", "multiple"});
    EXPECT_FALSE(exists("out/validation.json"));
}

// A blend unit that does not round as the format says makes another image, where the driver's is one.
TEST_F(ValidateCli, DifferencesAreFound) {
    RandomFragments options;
    options.count = 20000;
    write_random(options);
    const auto driver = validated({"--technique", "alpha_blend"})["driver"];
    if (driver["rounds_float16"].get<bool>()) GTEST_SKIP() << "the driver rounds halves to nearest";
    const ProgramResult r = run_program({"validate", path("random.trace"), "--technique", "alpha_blend",
                                         "--blending", "fixed", "-o", path("out")});
    EXPECT_EQ(r.status, 1);
    EXPECT_THAT(r.out, HasSubstr("DIFFERS"));
    EXPECT_THAT(r.err, HasSubstr("ropsim: validate: 1 of 1 techniques differ by more than they may"));
    const auto json = nlohmann::json::parse(read_file(path("out/validation.json")));
    const auto& first = json["techniques"][0]["first"];
    EXPECT_TRUE(first["same_fragments"].get<bool>());
    EXPECT_GT(first["model_fragments"].size(), 0u);
    EXPECT_EQ(first["model_fragments"], first["drawn_fragments"]);
    EXPECT_NE(first["model"], first["drawn"]);
    // What the driver does instead is known: with halves cut off in the shader it is the same image, bit for
    // bit.
    run_program({"validate", path("random.trace"), "--technique", "alpha_blend", "--blending", "shader-cut",
                 "-o", path("cut")});
    EXPECT_EQ(read_file(path("out/difference-alpha_blend.exr")),
              read_file(path("cut/difference-alpha_blend.exr")));
}

TEST_F(ValidateCli, WrongInputIsRefused) {
    const std::string out = path("out");
    expect_refused({"validate", "no_such_scene", "-o", out}, {"no_such_scene", "neither a scene nor a file"});
    expect_refused({"validate", path("trace"), "--size", "64x64", "-o", out}, {"is a trace", "--size"});
    expect_refused({"validate", path("missing.trace"), "-o", out}, {"missing.trace"});
    expect_refused({"validate", path("trace"), "--technique", "shadow_map", "-o", out},
                   {"the software path has no 'shadow_map'", "alpha_blend"});
    expect_refused({"validate", path("trace"), "--technique", "nothing", "-o", out},
                   {"--technique", "nothing"});
    expect_refused({"validate", path("trace"), "--technique", "stochastic:filter=gaussian", "-o", out},
                   {"filter"});
    expect_refused({"validate", path("trace"), "--technique", "alpha_blend:color_format=log8", "-o", out},
                   {"color_format", "unorm8"});
    expect_misused({"validate", path("trace"), "--blending", "perfect", "-o", out});
    expect_misused({"validate", path("trace")});
}

}  // namespace
}  // namespace ropsim
