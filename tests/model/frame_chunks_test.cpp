// Chunks of the trace that a frame keeps from its first pass for the later ones, and the order in which it
// runs their fragments: nothing but speed depends on either.
#include "tests/model/machine_driver.h"

#include <cstring>

namespace ropsim {
namespace {

// The trace, decoded anew in every pass: nothing of it is kept.
class Anew : public FragmentSource {
 public:
    explicit Anew(TraceReader& trace) : trace_(trace) {}
    bool next(FragmentChunk& chunk, unsigned wanted, std::uint8_t) override {
        if (trace_.next(chunk, wanted)) return true;
        trace_.rewind();
        return false;
    }

 private:
    TraceReader& trace_;
};

struct Outcome {
    Image image;
    FragmentCounts counts;
    SkipCounts skipped;
    std::vector<SurfaceTraffic> traffic;
    std::vector<std::uint64_t> paths;
    std::vector<std::uint8_t> covered;
    std::uint64_t quads = 0;
    int passes = 0;
};

class FrameChunksTest : public ModelTest, public ::testing::WithParamInterface<std::string> {
 protected:
    std::string trace_in_chunks() const {
        RandomFragments o;
        o.seed = 5;
        o.width = 83;
        o.height = 61;
        o.count = 30000;
        o.depth_levels = 300;
        o.alpha_high = 0.5f;
        o.draws = 3;
        o.opaque = true;
        TraceWriter writer(path("trace"), random_header(o), {4096, 16});
        writer.append(random_fragments(o));
        writer.finish();
        return path("trace");
    }
    static Outcome outcome(TraceReader& trace, const std::string& technique, const MachineConfig& config,
                           int threads, bool quads, bool kept) {
        const auto operation = operation_for(technique, trace.header(), 9);
        Anew anew(trace);
        Frame frame(trace, *operation, config, threads, quads);
        if (!kept) frame.take_fragments_from(anew);
        Outcome o;
        QuadBatch batch;
        while (frame.advance(batch)) o.quads += batch.quads.size();
        o.image = frame.image();
        o.counts = frame.fragments();
        o.skipped = frame.skipped();
        o.traffic = frame.traffic();
        for (std::size_t p = 0; p < frame.cost().size(); ++p) o.paths.push_back(frame.path_count(p));
        o.covered = frame.covered();
        o.passes = frame.geometry_passes_run();
        return o;
    }
    static void expect_same(const Outcome& a, const Outcome& b) {
        EXPECT_EQ(0, std::memcmp(a.image.values.data(), b.image.values.data(),
                                 a.image.values.size() * sizeof(float)));
        EXPECT_EQ(a.counts.input, b.counts.input);
        EXPECT_EQ(a.counts.depth_culled, b.counts.depth_culled);
        EXPECT_EQ(a.counts.zero_alpha, b.counts.zero_alpha);
        EXPECT_EQ(a.counts.operated, b.counts.operated);
        EXPECT_EQ(a.skipped.occluded_fragments, b.skipped.occluded_fragments);
        EXPECT_EQ(a.skipped.zero_alpha_fragments, b.skipped.zero_alpha_fragments);
        EXPECT_EQ(a.skipped.outside_fragments, b.skipped.outside_fragments);
        ASSERT_EQ(a.traffic.size(), b.traffic.size());
        for (std::size_t s = 0; s < a.traffic.size(); ++s) {
            EXPECT_EQ(a.traffic[s].read, b.traffic[s].read) << s;
            EXPECT_EQ(a.traffic[s].write, b.traffic[s].write) << s;
            EXPECT_EQ(a.traffic[s].worst_read, b.traffic[s].worst_read) << s;
            EXPECT_EQ(a.traffic[s].worst_write, b.traffic[s].worst_write) << s;
        }
        EXPECT_EQ(a.paths, b.paths);
        EXPECT_EQ(a.covered, b.covered);
        EXPECT_EQ(a.quads, b.quads);
        EXPECT_EQ(a.passes, b.passes);
    }
};

TEST_P(FrameChunksTest, WhatIsKeptIsWhatWouldBeDecodedAgain) {
    const std::string file = trace_in_chunks();
    for (const bool quads : {false, true}) {
        for (const int threads : {1, 2}) {
            SCOPED_TRACE(fmt::format("quads {}, {} threads", quads, threads));
            const MachineConfig config = configured();
            TraceReader trace(file);
            expect_same(outcome(trace, GetParam(), config, threads, quads, true),
                        outcome(trace, GetParam(), config, threads, quads, false));
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Techniques, FrameChunksTest, ::testing::ValuesIn(technique_names()),
                         [](const auto& param) { return param.param; });

using KeptChunksTest = FrameChunksTest;

TEST_P(KeptChunksTest, AreDecodedOnce) {
    const std::string file = trace_in_chunks();
    const MachineConfig config = configured({"skip.region=8 8 40 40"});
    TraceReader once(file);
    const Outcome blended = outcome(once, "alpha_blend", config, 1, false, true);
    ASSERT_EQ(blended.passes, 1);
    for (const bool quads : {false, true}) {
        TraceReader trace(file);
        const Outcome kept = outcome(trace, GetParam(), config, 1, quads, true);
        EXPECT_GT(kept.passes, 1);
        EXPECT_EQ(trace.decoded_blocks(), once.decoded_blocks());
        // What lies outside the region is dropped, and counted, in every pass.
        EXPECT_EQ(kept.skipped.outside_fragments,
                  static_cast<std::uint64_t>(kept.passes) * blended.skipped.outside_fragments);
    }
}

TEST_P(KeptChunksTest, AreDecodedInEveryPassIfNoneIsToBeKept) {
    const std::string file = trace_in_chunks();
    const MachineConfig config = configured();
    const auto blocks_and_passes = [&](bool keep) {
        TraceReader trace(file);
        const auto operation = operation_for(GetParam(), trace.header(), 9);
        Frame frame(trace, *operation, config, 1, true);
        if (!keep) frame.keep_no_fragments();
        QuadBatch batch;
        while (frame.advance(batch)) {
        }
        return std::pair(trace.decoded_blocks(), static_cast<std::uint64_t>(frame.geometry_passes_run()));
    };
    const auto [once, passes] = blocks_and_passes(true);
    EXPECT_EQ(blocks_and_passes(false), std::pair(once * passes, passes));
}

INSTANTIATE_TEST_SUITE_P(Techniques, KeptChunksTest,
                         ::testing::Values("adaptive", "depth_peeling:layers=4", "moment_based"),
                         [](const auto& param) { return param.param.substr(0, param.param.find(':')); });

}  // namespace
}  // namespace ropsim
