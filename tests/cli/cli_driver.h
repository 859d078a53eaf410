// What the tests of the command line share: a small trace, and what is expected of a command.
#pragma once

#include "base/atomic_file.h"
#include "tests/cli/program.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace ropsim {

using Arguments = std::vector<std::string>;

class Cli : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        RandomFragments options;
        options.count = 500;
        options.opaque = true;
        options.draws = 2;
        write_trace(path("trace"), random_header(options), random_fragments(options));
    }
    bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }

    // Exit 1 with one line "ropsim: ..." that holds each of `words`, nothing on stdout.
    void expect_refused(const Arguments& arguments, const std::vector<std::string>& words) const {
        const ProgramResult r = run_program(arguments);
        EXPECT_EQ(r.status, 1) << spelled(arguments) << "\n" << r.err;
        EXPECT_THAT(r.err, ::testing::StartsWith("ropsim: ")) << spelled(arguments);
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << spelled(arguments) << "\n" << r.err;
        EXPECT_EQ(r.out, "") << spelled(arguments);
        for (const std::string& word : words)
            EXPECT_THAT(r.err, ::testing::HasSubstr(word)) << spelled(arguments);
    }
    void expect_misused(const Arguments& arguments) const {
        const ProgramResult r = run_program(arguments);
        EXPECT_EQ(r.status, 2) << spelled(arguments) << "\n" << r.err;
        EXPECT_NE(r.err, "") << spelled(arguments);
        EXPECT_EQ(r.out, "") << spelled(arguments);
    }
    std::string expect_done(const Arguments& arguments) const {
        const ProgramResult r = run_program(arguments);
        EXPECT_EQ(r.status, 0) << spelled(arguments) << "\n" << r.err;
        return r.out;
    }
    nlohmann::json expect_json(const Arguments& arguments) const {
        const std::string out = expect_done(arguments);
        EXPECT_TRUE(nlohmann::json::accept(out)) << spelled(arguments) << "\n" << out;
        return nlohmann::json::parse(out, nullptr, false);
    }
    Arguments run_of(const std::string& trace, const Arguments& more = {}) const {
        Arguments all = {"run", path(trace), "--technique", "alpha_blend", "-o", path("out")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

}  // namespace ropsim
