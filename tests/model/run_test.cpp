// Runs that fail leave no result, and no result of an earlier run beside new images.
#include "model/run.h"

#include "model/run_json.h"
#include "tests/model/machine_driver.h"

#include <filesystem>

namespace ropsim {
namespace {

class RunTest : public ModelTest {
 protected:
    void SetUp() override {
        ModelTest::SetUp();
        write(plain_header(16, 16), {fragment_at(3, 3, 0.5f, 0), fragment_at(4, 3, 0.25f, 1)});
        options_.trace = path("trace");
        options_.technique = "alpha_blend";
        options_.fidelity = Fidelity::kCount;
    }
    bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }
    RunOptions options_;
};

TEST_F(RunTest, WritesItsThreeFiles) {
    const RunResult result = run_simulation(options_);
    EXPECT_EQ(result.fragments, 2u);
    EXPECT_EQ(result.counts.operated, 2u);
    EXPECT_FALSE(result.machine);
    ASSERT_TRUE(result.error);
    write_run(result, path("out/deeper"));
    for (const char* file : {"run.json", "image.exr", "image.png"})
        EXPECT_TRUE(exists(std::string("out/deeper/") + file));
    std::size_t files = 0;
    for ([[maybe_unused]] const auto& f : std::filesystem::directory_iterator(path("out/deeper"))) ++files;
    EXPECT_EQ(files, 3u);
}

// A pane that covers its pixel and lets three quarters through is, to techniques that know alpha alone, one
// of alpha 1/4.
TEST_F(RunTest, AlphaAloneIsTheLeastAlpha) {
    const auto image_of = [&](float alpha, float transmission) {
        FragmentChunk pane;
        pane.fragments = {fragment_at(3, 3, 0.5f, 0)};
        pane.fragments[0].a = alpha;
        pane.materials.resize(1);
        for (float& t : pane.materials[0].transmission) t = transmission;
        TraceHeader header = plain_header(16, 16);
        header.background = {0.5f, 0.25f, 1};
        header.materials = true;
        TraceWriter writer(path("pane"), header);
        writer.append(pane);
        writer.finish();
        options_.trace = path("pane");
        options_.technique = "a_buffer:format=float32,image_format=float32";
        const RunResult result = run_simulation(options_);
        EXPECT_LT(result.error->max_abs, 1e-6);
        return result.image.values;
    };
    EXPECT_EQ(image_of(1, 0.75f), image_of(0.25f, 0));
    EXPECT_NE(image_of(1, 0.75f), image_of(1, 0));
}

TEST_F(RunTest, BadInputThrowsAUserErrorAndNothingElse) {
    const auto refused = [&](auto&& change) {
        RunOptions bad = options_;
        change(bad);
        EXPECT_THROW(run_simulation(bad), UserError);
    };
    refused([](RunOptions& o) { o.trace += "x"; });
    refused([](RunOptions& o) { o.technique = "alpha"; });
    refused([](RunOptions& o) { o.technique = "adaptive:nodes=1"; });
    refused([](RunOptions& o) { o.technique = "adaptive:knots=8"; });
    refused([](RunOptions& o) { o.hardware = "laptop"; });
    refused([](RunOptions& o) { o.settings = {"rop.lanes=0"}; });
    refused([](RunOptions& o) { o.settings = {"rop.ranes=1"}; });
    for (const Fidelity f : {Fidelity::kCached, Fidelity::kCount})
        refused([&](RunOptions& o) {
            o.fidelity = f;
            o.settings = {"rop.partitions=1", "pool.mebibytes=100000"};
            o.technique = "a_buffer";
        });
}

// write_run takes the old run.json away before the first new file appears.
TEST_F(RunTest, AStaleResultGoesFirst) {
    std::filesystem::create_directories(path("out/image.exr"));  // in the way: writing the image fails
    write_file(path("out/run.json"), "{}");
    EXPECT_THROW(write_run(run_simulation(options_), path("out")), UserError);
    EXPECT_FALSE(exists("out/run.json"));
}

TEST_F(RunTest, ADirectoryThatCannotBeIsRefused) {
    write_file(path("file"), "x");
    EXPECT_THROW(write_run(run_simulation(options_), path("file")), UserError);
    EXPECT_THROW(write_run(run_simulation(options_), path("file/below")), UserError);
}

TEST_F(RunTest, SeedsAreKeptApart) {
    RandomFragments random;
    write_trace(path("random"), random_header(random), random_fragments(random));
    options_.trace = path("random");
    options_.technique = "stochastic:samples=8";
    options_.seed = 1;
    const Image one = run_simulation(options_).image;
    EXPECT_EQ(one.values, run_simulation(options_).image.values);
    options_.seed = 2;
    EXPECT_NE(one.values, run_simulation(options_).image.values);
}

// run.json says what `error` is against.
TEST_F(RunTest, TheReferenceIsTheOneThatTheTechniqueDeclares) {
    RunResult result = run_simulation(options_);
    EXPECT_EQ(nlohmann::json::parse(run_json(result))["error"]["reference"], "alpha");
    result.declaration.colored_transmission = true;
    EXPECT_EQ(nlohmann::json::parse(run_json(result))["error"]["reference"], "colored transmission");
}

}  // namespace
}  // namespace ropsim
