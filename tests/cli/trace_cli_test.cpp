// `ropsim trace ...`: what its commands write, say and refuse.
#include "tests/cli/cli_driver.h"
#include "traces/image.h"
#include "traces/stress_traces.h"
#include "traces/trace.h"

namespace ropsim {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class TraceCli : public Cli {
 protected:
    json info(const std::string& name) const { return expect_json({"trace", "info", path(name), "--json"}); }
};

TEST_F(TraceCli, DeepExrGoesThereAndBack) {
    expect_done({"trace", "export", path("trace"), "-o", path("f.exr")});
    expect_done({"trace", "import", path("f.exr"), "-o", path("back")});
    EXPECT_EQ(read_file(path("back")), read_file(path("trace")));
    // With an order it is as any other program's file.
    const ProgramResult r = run_program(
        {"trace", "import", path("f.exr"), "-o", path("any"), "--order", "shuffle", "--seed", "4"});
    EXPECT_EQ(r.status, 0);
    EXPECT_EQ(r.err, "ropsim: " + path("f.exr") + ": depth is Z * 2^-0\n");
    EXPECT_THAT(info("any")["scene"], HasSubstr("order shuffle seed 4"));
    EXPECT_EQ(info("any")["fragments"], 500);
    expect_refused({"trace", "export", path("trace"), "-o", path("f.png")}, {"f.png", ".csv", ".exr"});
    write_file(path("f.csv"), "x,y,z,r,g,b,a\n0,0,0,0,0,0,0\n");
    expect_refused({"trace", "import", path("f.csv"), "-o", path("t"), "--order", "file"}, {"--order"});
    expect_misused({"trace", "import", path("f.exr"), "-o", path("t"), "--order", "inside_out"});
}

TEST_F(TraceCli, CsvTellsWhatItLeavesOutAndMisses) {
    const ProgramResult out = run_program({"trace", "export", path("trace"), "-o", path("f.csv")});
    EXPECT_THAT(out.err, HasSubstr("the opaque layer is not part of a CSV file"));
    std::string text = read_file(path("f.csv"));
    text.resize(text.rfind('\n', text.size() - 2) + 1);
    write_file(path("f.csv"), text);
    const ProgramResult in = run_program({"trace", "import", path("f.csv"), "-o", path("t")});
    EXPECT_EQ(in.status, 0);
    EXPECT_THAT(in.err, HasSubstr("holds 499 fragments where its comment '# fragments 500'"));
}

TEST_F(TraceCli, InfoHasItsChannels) {
    const json plain = info("trace");
    EXPECT_EQ(plain["view"], "camera");
    for (const char* key : {"light", "depth_slopes", "materials", "non_finite"}) {
        ASSERT_TRUE(plain.contains(key)) << key;
        EXPECT_TRUE(plain[key].is_null()) << key;
    }
    write_stress_trace("non_finite", path("odd"));
    const json odd = info("odd");
    EXPECT_EQ(odd["non_finite"]["with_nan"], 15);
    EXPECT_EQ(odd["materials"]["refractive"], 314);
    EXPECT_GT(odd["depth_slopes"]["steepest"], 1e38);
    const std::string text = expect_done({"trace", "info", path("odd")});
    for (const char* word : {"with NaN", "refract", "depth slopes", "seen from         camera", "0.9 to 1.0"})
        EXPECT_THAT(text, HasSubstr(word));
}

TEST_F(TraceCli, OverdrawIsAPictureWithItsScaleExplained) {
    for (const char* counted : {"all", "visible"}) {
        const ProgramResult r = run_program(
            {"trace", "info", path("trace"), "--overdraw", path("o.png"), "--overdraw-of", counted});
        EXPECT_EQ(r.status, 0);
        const std::uint64_t most = info(
            "trace")[counted == std::string("all") ? "depth_complexity" : "visible_depth_complexity"]["max"];
        EXPECT_THAT(r.err, HasSubstr("logarithmic from 1 (violet) to " + std::to_string(most) + " (yellow)"));
        EXPECT_EQ(read_file(path("o.png")).substr(1, 3), "PNG");
    }
    expect_refused({"trace", "info", path("trace"), "--overdraw", path("o.jpg")}, {"o.jpg", ".png"});
}

TEST_F(TraceCli, CutAndOrder) {
    expect_done({"trace", "cut", path("trace"), "--region", "0,0,16x32", "--draws", "1", "--first", "50",
                 "-o", path("cut")});
    EXPECT_EQ(info("cut")["fragments"], 50);
    EXPECT_EQ(info("cut")["width"], 32);
    EXPECT_EQ(info("cut")["draw_list"][0]["fragments"], 0);
    expect_done({"trace", "cut", path("trace"), "--every-nth-tile", "4", "-o", path("cut")});
    EXPECT_LT(info("cut")["fragments"], 250);
    expect_done({"trace", "cut", path("trace"), "--first", "0", "-o", path("cut")});
    EXPECT_EQ(info("cut")["fragments"], 0);
    expect_refused({"trace", "cut", path("trace"), "--region", "0,0,33x1", "-o", path("no")},
                   {"--region", "32x32"});
    expect_refused({"trace", "cut", path("trace"), "--draws", "7", "-o", path("no")}, {"--draws", "7"});
    expect_misused({"trace", "cut", path("trace"), "--every-nth-tile", "0", "-o", path("no")});
    for (const char* order : {"near_to_far", "far_to_near", "shuffle", "primitive", "tile"}) {
        expect_done({"trace", "order", path("trace"), "--order", order, "-o", path("o")});
        EXPECT_EQ(info("o")["fragments"], 500);
    }
    const std::vector<Fragment> tiles = read_fragments(path("o"));
    EXPECT_TRUE(std::is_sorted(tiles.begin(), tiles.end(), [](const Fragment& a, const Fragment& b) {
        return std::pair(a.y / 8, a.x / 8) < std::pair(b.y / 8, b.x / 8);
    }));
    expect_misused({"trace", "order", path("trace"), "-o", path("no")});
    expect_misused({"trace", "order", path("trace"), "--order", "age", "-o", path("no")});
    EXPECT_FALSE(exists("no"));
}

TEST_F(TraceCli, AnInputIsNotReplaced) {
    const std::string before = read_file(path("trace"));
    const std::string other_name = path("link.exr");
    std::filesystem::create_symlink(path("trace"), other_name);
    const auto same = [&](const Arguments& command, const std::string& output) {
        Arguments all = command;
        all.insert(all.end(), {"-o", output});
        expect_refused(all, {output, "also an input", "choose another output"});
        EXPECT_TRUE(read_file(path("trace")) == before) << spelled(all);
        EXPECT_TRUE(std::filesystem::is_symlink(other_name)) << spelled(all);
    };
    for (const std::string& output : {path("trace"), path("./trace"), other_name}) {
        same({"trace", "cut", path("trace"), "--first", "1"}, output);
        same({"trace", "order", path("trace"), "--order", "shuffle"}, output);
        same({"trace", "opaque", path("trace")}, output);
        same({"trace", "volume", path("trace")}, output);
        same({"trace", "volume", path("missing"), "--shadows", path("trace")}, output);
        same({"trace", "import", path("trace")}, output);
        same({"reference", path("trace")}, output);
    }
    same({"trace", "export", path("trace")}, other_name);
    for (const char* name : {"run.json", "image.exr", "image.png", "report.html", "tradeoff.csv",
                             "convergence.json", "curve.json", "order-sensitivity.json"}) {
        std::filesystem::create_directory(path("out"));
        const std::string file = path(std::string("out/") + name);
        std::filesystem::copy_file(path("trace"), file);
        const std::string stem = std::filesystem::path(name).stem();
        Arguments all = stem == "report" ? Arguments{"compare", file, "--technique", "alpha_blend"}
                        : stem == "tradeoff" || stem == "order-sensitivity"
                            ? Arguments{stem, file, "--technique", "alpha_blend"}
                        : stem == "convergence" ? Arguments{stem,    file,      "--technique", "stochastic",
                                                            "--key", "samples", "--values",    "1,2,4"}
                        : stem == "curve" ? Arguments{stem, file, "--pixel", "3,3", "--technique", "a_buffer"}
                                          : Arguments{"run", file, "--technique", "alpha_blend"};
        all.insert(all.end(), {"-o", path("out")});
        expect_refused(all, {file, "also an input"});
        EXPECT_TRUE(read_file(file) == before) << spelled(all);
        std::filesystem::remove_all(path("out"));
    }
}

TEST_F(TraceCli, Stress) {
    const std::string list = expect_done({"trace", "stress", "--list"});
    expect_done({"trace", "stress", "--all", "-o", path("all")});
    for (const StressTrace& stress : stress_traces()) {
        EXPECT_THAT(list, HasSubstr(stress.name));
        EXPECT_TRUE(exists("all/" + std::string(stress.name) + ".trace"));
    }
    expect_done({"trace", "stress", "deep_pixel", "--seed", "3", "-o", path("one")});
    EXPECT_EQ(info("one")["depth_complexity"]["max"], 10000);
    EXPECT_NE(read_file(path("one")), read_file(path("all/deep_pixel.trace")));
    expect_refused({"trace", "stress", "calm", "-o", path("no")}, {"calm", "coplanar"});
    expect_misused({"trace", "stress"});
    expect_misused({"trace", "stress", "coplanar"});
    expect_misused({"trace", "stress", "coplanar", "--all", "-o", path("no")});
}

}  // namespace
}  // namespace ropsim
