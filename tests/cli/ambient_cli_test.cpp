// `ropsim ambient`: what a whole study leaves, and what it refuses.
#include "tests/cli/cli_driver.h"
#include "traces/image.h"

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr int kSide = 48;

// A right-angled valley of opaque sides, seen from above, and leaves of 10 x 10 pixels over it, whose
// outermost pixels have alpha 0.5 and whose corners a pane of glass touches.
class AmbientCli : public Cli {
 protected:
    void SetUp() override {
        Cli::SetUp();
        header_.width = header_.height = kSide;
        header_.scene = "leaves in a valley";
        header_.draws.resize(2);
        header_.draws[0].name = "leaves";
        header_.draws[0].full = {40, 2, 16};
        header_.draws[1].name = "pane";
        header_.camera.emplace();
        header_.camera->projection = glm::ortho(-1.5f, 1.5f, -1.5f, 1.5f, 0.0f, 10.0f);
        header_.opaque.emplace();
        header_.opaque->rgb.assign(std::size_t{3} * kSide * kSide, 0.5f);
        for (int i = 0; i < kSide * kSide; ++i)
            header_.opaque->depth.push_back(
                0.6f - 0.1f * std::abs((static_cast<float>(i % kSide) + 0.5f) / 16 - 1.5f));
        for (const int left : {8, 20, 30}) add_leaf(left, 14, static_cast<std::uint32_t>(2 * left));
        for (int x = 0; x < kSide; x += 3) add(x, 14, 0.2f, 0.25f, 0, 1);
        write_trace(path("leaves"), header_, fragments_);
    }
    void add(int x, int y, float z, float a, std::uint32_t primitive, std::uint16_t draw) {
        fragments_.push_back({z, 0.4f * a, 0.6f * a, 0.2f * a, a, static_cast<std::uint16_t>(x),
                              static_cast<std::uint16_t>(y), primitive, 1, draw});
    }
    void add_leaf(int left, int top, std::uint32_t primitive) {
        for (int y = 0; y < 10; ++y)
            for (int x = 0; x < 10; ++x) {
                const bool inside = x > 0 && y > 0 && x < 9 && y < 9;
                const float z = left == 20 ? 0.53f : 0.485f;  // below the upper ends of the sides
                add(left + x, top + y, z, inside ? 1.0f : 0.5f, primitive, 0);
            }
    }
    Arguments ambient(const std::string& trace, const Arguments& more = {}) const {
        // Much occlusion, and taps that hardly see what lies below a leaf.
        Arguments all = {"ambient", path(trace),     "-o",   path("out"), "--intensity",
                         "4",       "--half-weight", "0.001"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    nlohmann::json study(const Arguments& more = {}) const {
        expect_done(ambient("leaves", more));
        nlohmann::json json = nlohmann::json::parse(read_file(path("out/ambient.json")));
        json.erase("host");
        return json;
    }
    std::vector<Fragment> shaded() const { return read_fragments(path("out/ambient.trace")); }

    TraceHeader header_;
    std::vector<Fragment> fragments_;
};

TEST_F(AmbientCli, AStudyLeavesATracePicturesAndNumbers) {
    const nlohmann::json json = study({"--solid", "leaves"});
    for (const char* name : {"out/ao.exr", "out/ao.png", "out/before.png", "out/after.png"})
        EXPECT_TRUE(exists(name)) << name;
    const auto& counts = json["fragments"];
    EXPECT_EQ(counts["input"], 3 * 100 + kSide / 3);
    // Leaves are 64 whole fragments and 36 at the edge; none reaches another's columns and nothing is nearer.
    EXPECT_EQ(counts["solid"], 3 * 64);
    EXPECT_EQ(counts["line"].get<int>() + counts["box"].get<int>(), 3 * 36);
    EXPECT_EQ(counts["hidden"], 0);
    EXPECT_EQ(counts["other"], kSide / 3);
    EXPECT_EQ(json["draws"][1]["other"], kSide / 3);
    const std::uint64_t lines = counts["line"];
    const std::uint64_t boxes = counts["box"];
    const auto& inference = json["inference"];
    EXPECT_EQ(inference["taps"], 12 * lines + 49 * boxes);
    EXPECT_EQ(inference["texture_fetches"], 24 * lines + 98 * boxes);
    EXPECT_EQ(inference["read_bytes"], 60 * lines + 245 * boxes);
    EXPECT_EQ(inference["alu_instructions"], 202 * lines + 792 * boxes);
    EXPECT_LE(inference["distinct_read_bytes"], 5 * kSide * kSide);
    // Two passes of 9 taps, 2 pixels apart; of the taps by k the 2 k outermost pixels have none.
    const int taps = 9 * kSide - 2 * 2 * (1 + 2 + 3 + 4);
    EXPECT_EQ(json["buffer"]["blur_texture_fetches"], 2 * 2 * taps * kSide);
    EXPECT_EQ(json["buffer"]["blur_read_bytes"], 5 * 2 * taps * kSide);
    EXPECT_EQ(json["buffer"]["pixels"], kSide * kSide);
    EXPECT_EQ(json["buffer"]["write_bytes"], kSide * kSide);
    EXPECT_EQ(json["buffer"]["opaque_pixels"], kSide * kSide - 3 * 64);
    // Leaves are as bright at their edges as inside, without ambient occlusion and with the inferred one.
    EXPECT_NEAR(json["edge_step"]["without"], 0, 1e-6);
    EXPECT_GT(json["edge_step"]["solid_only"], 0.02);
    EXPECT_LT(std::abs(json["edge_step"]["inferred"].get<double>()), 0.01);
}

TEST_F(AmbientCli, ColoursAreDimmedByTheShareOfAmbientLight) {
    study({"--solid", "leaves", "--ambient", "0.25", "--format", "float32"});
    const Image ao = read_exr(path("out/ao.exr"));
    const std::vector<Fragment> after = shaded();
    ASSERT_EQ(after.size(), fragments_.size());
    double least = 1;
    for (std::size_t i = 0; i < after.size(); ++i) {
        const Fragment& f = fragments_[i];
        EXPECT_EQ(after[i].z, f.z);
        EXPECT_EQ(after[i].a, f.a);
        const float factor = f.draw == 1 ? 1.0f : 1 - 0.25f * (1 - ao.pixel(f.x, f.y)[0]);
        if (f.draw == 1 || f.a == 1.0f) {
            EXPECT_NEAR(after[i].r, f.r * factor, 1e-6) << i;
            EXPECT_NEAR(after[i].g, f.g * factor, 1e-6) << i;
            EXPECT_NEAR(after[i].b, f.b * factor, 1e-6) << i;
        }
        least = std::min(least, static_cast<double>(after[i].g / f.g));
    }
    EXPECT_LT(least, 0.95);
    EXPECT_GE(least, 0.75);
    // Nothing ambient: nothing changes.
    study({"--solid", "leaves", "--ambient", "0"});
    for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(shaded()[i].g, fragments_[i].g);
}

TEST_F(AmbientCli, WithoutInferenceEdgesStayBright) {
    const nlohmann::json json = study({"--solid", "leaves", "--infer", "off"});
    EXPECT_TRUE(json["inference"].is_null());
    EXPECT_TRUE(json["edge_step"]["inferred"].is_null());
    EXPECT_GT(json["edge_step"]["solid_only"], 0.02);
    const std::vector<Fragment> after = shaded();
    for (std::size_t i = 0; i < after.size(); ++i)
        if (fragments_[i].a < 1) {
            EXPECT_EQ(after[i].g, fragments_[i].g) << i;
        }
}

TEST_F(AmbientCli, ShadersOfCutoutsCostMore) {
    const nlohmann::json json = study({"--solid", "leaves"});
    const std::uint64_t lines = json["fragments"]["line"];
    const std::uint64_t boxes = json["fragments"]["box"];
    const TraceReader trace(path("out/ambient.trace"));
    const double mean_fetches = static_cast<double>(24 * lines + 98 * boxes + 192) / 300;  // 3 x 64 whole
    const double mean_operations = static_cast<double>(202 * lines + 792 * boxes) / 300;
    const Draw& leaves = trace.header().draws[0];
    const auto& shader = json["draws"][0]["shader"];
    EXPECT_EQ(shader["before"]["alu_instructions"], 40);
    EXPECT_EQ(shader["after"]["alu_instructions"], leaves.full.alu_instructions);
    EXPECT_EQ(leaves.full.texture_fetches, 2 + std::lround(mean_fetches));
    EXPECT_EQ(leaves.full.alu_instructions, 40 + std::lround(mean_operations));
    EXPECT_EQ(leaves.alpha.alu_instructions, header_.draws[0].alpha.alu_instructions) << "needs no light";
    EXPECT_THAT(leaves.cost_source, ::testing::HasSubstr("ambient occlusion"));
    EXPECT_EQ(trace.header().draws[1].full.alu_instructions, header_.draws[1].full.alu_instructions);
}

TEST_F(AmbientCli, AllFragmentsThatAMachineOperatesShareTheCharge) {
    const nlohmann::json alone = study({"--solid", "leaves"})["draws"][0];
    // A fragment more behind each whole one, in front of the valley: it receives nothing, but only the opaque
    // layer culls. One is behind that.
    for (std::size_t i = 0; i < 300; ++i) {
        Fragment f = fragments_[i];
        f.a = 0.5f;
        f.primitive += 1000;
        f.z = f.z == 0.53f ? 0.531f : 0.486f;
        if (fragments_[i].a == 1) fragments_.push_back(f);
    }
    Fragment below = fragments_[0];
    below.z = 0.99f;
    fragments_.push_back(below);
    write_trace(path("leaves"), header_, fragments_);
    const nlohmann::json more = study({"--solid", "leaves"})["draws"][0];
    EXPECT_EQ(more["hidden"], 3 * 64 + 1);
    for (const char* kind : {"solid", "line", "box"}) EXPECT_EQ(more[kind], alone[kind]);
    const double lines = alone["line"].get<double>();
    const double boxes = alone["box"].get<double>();
    EXPECT_EQ(more["shader"]["after"]["alu_instructions"],
              40 + std::lround((202 * lines + 792 * boxes) / (300 + 3 * 64)));
    EXPECT_EQ(more["shader"]["after"]["texture_fetches"],
              2 + std::lround((24 * lines + 98 * boxes + 3 * 64) / (300 + 3 * 64)));
}

TEST_F(AmbientCli, BlackLeavesHaveNoStep) {
    for (Fragment& f : fragments_) f.r = f.g = f.b = 0;
    write_trace(path("leaves"), header_, fragments_);
    const nlohmann::json step = study({"--solid", "leaves"})["edge_step"];
    EXPECT_GT(step["pairs"], 0);
    for (const char* key : {"without", "solid_only", "inferred"}) EXPECT_TRUE(step[key].is_null()) << key;
    EXPECT_GT(step["ao_difference_solid_only"], 0);
}

TEST_F(AmbientCli, ADrawWithoutWholeFragmentsIsNoted) {
    const ProgramResult r = run_program(ambient("leaves", {"--solid", "leaves", "--solid", "pane"}));
    EXPECT_EQ(r.status, 0);
    EXPECT_THAT(r.err, ::testing::HasSubstr("no fragment of 'pane' is whole: its alpha is at most 0.250"));
    EXPECT_THAT(r.err, ::testing::Not(::testing::HasSubstr("of 'leaves' is whole")));
}

TEST_F(AmbientCli, ArrivalAndThreadsDoNotMatter) {
    nlohmann::json first = study({"--solid", "leaves", "--threads", "1"});
    const std::string trace = read_file(path("out/ambient.trace"));
    const std::string picture = read_file(path("out/after.png"));
    EXPECT_EQ(study({"--solid", "leaves", "--threads", "3"}), first);
    EXPECT_EQ(read_file(path("out/ambient.trace")), trace);
    expect_done({"trace", "order", path("leaves"), "--order", "shuffle", "-o", path("shuffled")});
    std::filesystem::rename(path("shuffled"), path("leaves"));
    nlohmann::json shuffled = study({"--solid", "leaves"});
    shuffled.erase("trace");
    first.erase("trace");
    EXPECT_EQ(shuffled, first);
    EXPECT_EQ(read_file(path("out/after.png")), picture);
}

TEST_F(AmbientCli, RefusalsSayWhatToDo) {
    expect_refused(ambient("leaves", {"--solid", "twigs"}), {"--solid", "'twigs'", "'leaves', 'pane'"});
    TraceHeader header = header_;
    header.camera.reset();
    write_trace(path("blind"), header, fragments_);
    expect_refused(ambient("blind", {"--solid", "leaves"}), {"blind", "has no camera"});
    header = header_;
    header.camera->projection = glm::mat4(0.0f);
    write_trace(path("flat"), header, fragments_);
    expect_refused(ambient("flat", {"--solid", "leaves"}), {"flat", "cannot be inverted"});
    header = header_;
    header.opaque.reset();
    write_trace(path("empty"), header, fragments_);
    expect_refused(ambient("empty"), {"empty", "no opaque layer", "'leaves', 'pane'"});
    expect_refused(ambient("empty", {"--solid", "pane"}), {"no fragment of alpha 0.999"});
    expect_done(ambient("empty", {"--solid", "leaves"}));
    header = header_;
    header.draws[0].depth_test = false;
    write_trace(path("untested"), header, fragments_);
    expect_refused(ambient("untested", {"--solid", "leaves"}), {"--solid", "'leaves'", "depth test"});
    RandomFragments sampled;
    sampled.samples = 4;
    sampled.count = 50;
    write_trace(path("samples"), random_header(sampled), random_fragments(sampled));
    expect_refused(ambient("samples"), {"samples", "4 spatial samples", "--samples 1"});
    expect_refused({"ambient", path("missing"), "-o", path("out")}, {"missing"});
    expect_refused({"ambient", path("leaves"), "-o", path("leaves") + "/out"}, {"choose another -o"});
    for (const Arguments& wrong : std::vector<Arguments>{{"--infer", "maybe"},
                                                         {"--helpers", "all"},
                                                         {"--radius", "0"},
                                                         {"--taps", "0"},
                                                         {"--format", "rgb9e5"},
                                                         {"--format", "1"},
                                                         {"--radius", "nan"},
                                                         {"--solid-alpha", "1.5"},
                                                         {"--ambient", "-1"},
                                                         {"--box-shift", "odd"}})
        expect_misused(ambient("leaves", wrong));
}

TEST_F(AmbientCli, AnInputIsNotReplaced) {
    std::filesystem::create_directory(path("out"));
    std::filesystem::rename(path("leaves"), path("out/ambient.trace"));
    const std::string before = read_file(path("out/ambient.trace"));
    expect_refused(ambient("out/ambient.trace"), {path("out/ambient.trace"), "also an input"});
    EXPECT_TRUE(read_file(path("out/ambient.trace")) == before);
    EXPECT_FALSE(exists("out/ao.exr"));
}

}  // namespace
}  // namespace ropsim
