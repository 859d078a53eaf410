// Every technique on the traces at the edges of what fragments can be: no NaN, no infinity, and no negative
// colour where none came in.
#include "traces/stress_traces.h"

#include "tests/rop/technique_cases.h"
#include "traces/depth_test.h"

#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace ropsim {
namespace {

using test::TestFrame;

// What reaches the operation of a stress trace.
struct StressFrame {
    std::string name;
    TraceHeader header;
    std::vector<Fragment> fragments;
    float least_color = 0;  // of fragments and background
};

std::vector<StressFrame> stress_frames() {
    namespace fs = std::filesystem;
    const fs::path path = fs::temp_directory_path() / fmt::format("ropsim_stress_{}.trace", ::getpid());
    std::vector<StressFrame> frames;
    for (const StressTrace& stress : stress_traces()) {
        if (std::string_view(stress.name) == "large_image") continue;  // its point is the size of the image
        write_stress_trace(stress.name, path.string());
        TraceReader reader(path.string());
        StressFrame frame{stress.name, reader.header(), {}, 0};
        const OpaqueDepthTest depth_test(reader.header());
        std::vector<Fragment> chunk;
        while (reader.next(chunk))
            for (const Fragment& f : chunk) {
                if (depth_test.visible_samples(f, {}) == 0) continue;
                frame.fragments.push_back(f);
                frame.least_color = std::min({frame.least_color, f.r, f.g, f.b});
            }
        // Techniques that measure depth along the view need to know it.
        if (!frame.header.camera) frame.header.camera = Camera{};
        frames.push_back(std::move(frame));
    }
    fs::remove(path);
    return frames;
}

class StressTraces : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, StressTraces, testing::ValuesIn(test::technique_texts()), test::test_name);

TEST_P(StressTraces, ImageIsFiniteAndNotNegative) {
    static const std::vector<StressFrame> frames = stress_frames();
    ASSERT_GE(frames.size(), 9u);
    for (const StressFrame& stress : frames) {
        TestFrame frame(GetParam(), stress.header, 1, 1u << 20, false);
        frame.draw(stress.fragments);
        if (!frame.declaration().image_is_color) continue;
        for (const float value : frame.image()) {
            ASSERT_TRUE(std::isfinite(value)) << stress.name;
            ASSERT_TRUE(value >= 0 || stress.least_color < 0) << stress.name << " gives " << value;
        }
    }
}

}  // namespace
}  // namespace ropsim
