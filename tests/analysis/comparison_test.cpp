// Child processes, and comparisons whose runs are played by a shell script.
#include "analysis/comparison.h"

#include "analysis/child_process.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "traces/trace.h"

#include <csignal>
#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace ropsim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(ChildProcess, ReportsHowItEnded) {
    const ChildResult good = run_child({"/bin/sh", "-c", "echo noise >&2"});
    EXPECT_EQ(good.exit_code, 0);
    EXPECT_EQ(good.failure(), "");
    const ChildResult bad =
        run_child({"/bin/sh", "-c", "echo first >&2; echo 'ropsim: x: is wrong' >&2; exit 1"});
    EXPECT_EQ(bad.exit_code, 1);
    EXPECT_EQ(bad.failure(), "x: is wrong");
    EXPECT_EQ(run_child({"/bin/sh", "-c", "exit 3"}).failure(), "exit code 3");
    const ChildResult killed = run_child({"/bin/sh", "-c", "kill -KILL $$"});
    EXPECT_EQ(killed.signal, SIGKILL);
    EXPECT_THAT(killed.failure(), HasSubstr("signal 9"));
    EXPECT_THROW(run_child({"/nonexistent/program"}), UserError);
}

TEST(ChildProcess, KeepsTheEndOfALongOutput) {
    const ChildResult result = run_child(
        {"/bin/sh", "-c",
         "i=0; while [ $i -lt 30000 ]; do echo 0123456789; i=$((i+1)); done >&2; echo end >&2; exit 1"});
    EXPECT_LE(result.error_output.size(), 65536u);
    EXPECT_EQ(result.failure(), "end");
}

TEST(ChildProcess, QuotesForTheShell) {
    EXPECT_EQ(shell_line({"ropsim", "a:b=1,c", "it's", "", "$x"}), "ropsim a:b=1,c 'it'\\''s' '' '$x'");
}

TEST(Slugs, AreSafeAndDifferent) {
    EXPECT_THAT(slugs({"slab:layers=8,bits=16", "a_buffer", "a/b", "a:b", "../x", "::", "a.b"}),
                ElementsAre("slab-layers-8-bits-16", "a_buffer", "a-b", "a-b-2", "x", "run", "a.b"));
}

class Comparison : public testing::Test {
 protected:
    void SetUp() override {
        std::string pattern = testing::TempDir() + "ropsim_compare_XXXXXX";
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        directory_ = pattern;
        ASSERT_EQ(setenv("XDG_CACHE_HOME", pattern.c_str(), 1), 0);
        // Plays `ropsim run TRACE --technique T ... -o DIR --threads N`.
        write_file((directory_ / "fake").string(), R"(#!/bin/sh
technique=$4
case $technique in
broken*) echo "ropsim: --technique: unknown technique" >&2; exit 1;;
silent*) exit 0;;
esac
while [ "$1" != -o ]; do options="$options $1"; shift; done
mkdir -p "$2"
echo "{\"error\": {\"rmse8\": 2.5}, \"configuration\": {\"arguments\": \"$options $3 $4\"}}" > "$2/run.json"
)");
        std::filesystem::permissions(directory_ / "fake", std::filesystem::perms::owner_all);
        options_.program = (directory_ / "fake").string();
        options_.directory = (directory_ / "out").string();
        options_.traces = {trace("one")};
    }
    void TearDown() override { std::filesystem::remove_all(directory_); }
    std::string trace(const std::string& name) {
        TraceHeader header;
        header.width = 10;
        header.height = 6;
        header.background = {.5f, .25f, 0.f};
        header.draws.resize(1);
        header.scene = "made for " + name;
        std::string path = (directory_ / (name + ".trace")).string();
        TraceWriter writer(path, header);
        Fragment f{};
        f.a = .5f;
        f.coverage = 1;
        writer.append(&f, 1);
        writer.finish();
        return path;
    }
    std::filesystem::path directory_;
    ComparisonOptions options_;
};

TEST_F(Comparison, CollectsRunsAndGoesOnAfterFailures) {
    options_.techniques = {"alpha_blend", "broken:key=1", "silent", "adaptive:nodes=8"};
    options_.run_options = {"--fidelity", "count"};
    options_.threads = 3;
    const auto comparisons = run_comparison(options_);
    ASSERT_EQ(comparisons.size(), 1u);
    const auto& [file, name, scene, hash, width, height, samples, fragments, reference, runs] =
        comparisons[0];
    EXPECT_EQ(name, "one");
    EXPECT_EQ(scene, "made for one");
    EXPECT_EQ(hash.size(), 16u);
    EXPECT_EQ(fragments, 1);
    EXPECT_EQ(reference.pixel(0, 0)[0], .25f);
    ASSERT_EQ(runs.size(), 4u);
    EXPECT_EQ(runs[0].failure, "");
    EXPECT_EQ(runs[0].rmse8, 2.5);
    EXPECT_EQ(runs[1].failure, "--technique: unknown technique");
    EXPECT_FALSE(runs[1].rmse8);
    EXPECT_THAT(runs[2].failure, HasSubstr("run.json"));
    EXPECT_EQ(runs[3].rmse8, 2.5);
    EXPECT_EQ(runs[3].directory, options_.directory + "/adaptive-nodes-8");
    EXPECT_EQ(runs[3].configuration.at("arguments"),
              " run " + options_.traces[0] + " --technique adaptive:nodes=8 --fidelity count --threads 3");
    EXPECT_EQ(shell_line(runs[3].command), "ropsim run " + options_.traces[0] +
                                               " --technique adaptive:nodes=8 --fidelity count -o " +
                                               runs[3].directory);
}

TEST_F(Comparison, SeveralTracesGetADirectoryEach) {
    std::filesystem::create_directories(directory_ / "other");
    options_.traces.push_back(trace("two"));
    options_.traces.push_back(trace("other/one"));
    const auto comparisons = run_comparison(options_);
    ASSERT_EQ(comparisons.size(), 3u);
    EXPECT_EQ(comparisons[2].name, "one-2");
    for (const auto& comparison : comparisons) {
        ASSERT_EQ(comparison.runs.size(), default_techniques().size());
        for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
            EXPECT_EQ(comparison.runs[i].technique, default_techniques()[i]);
            EXPECT_EQ(comparison.runs[i].failure, "");
        }
        EXPECT_TRUE(
            std::filesystem::exists(options_.directory + "/" + comparison.name + "/alpha_blend/run.json"));
    }
}

TEST_F(Comparison, RefusesBadInput) {
    options_.techniques = {"a_buffer", "a_buffer"};
    EXPECT_THROW(run_comparison(options_), UserError);
    options_.techniques = {"a_buffer"};
    options_.traces = {"/nonexistent.trace"};
    EXPECT_THROW(run_comparison(options_), UserError);
    options_.traces = {trace("one")};
    options_.directory = (directory_ / "fake" / "out").string();
    EXPECT_THROW(run_comparison(options_), UserError);
}

TEST_F(Comparison, AProgramThatIsNotThereIsAFailureOfItsRuns) {
    options_.program = "/nonexistent/program";
    options_.techniques = {"a_buffer"};
    EXPECT_THAT(run_comparison(options_)[0].runs[0].failure, HasSubstr("cannot be started"));
}

}  // namespace
}  // namespace ropsim
