// The stress traces through every form of the A-buffer and of the visibility maps: no pixel is without a
// number, and none is negative where no colour is.
#include "tests/rop/visibility_maps.h"
#include "traces/stress_traces.h"

#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

namespace ropsim {
namespace {

using test::TestFrame;

struct Read {
    TraceHeader header;
    std::vector<Fragment> fragments;
    bool negative = false;  // some colour is
};
Read stress_trace(const std::string& name) {
    std::string directory = testing::TempDir() + "ropsim_stress_XXXXXX";
    CHECK(mkdtemp(directory.data()) != nullptr);
    write_stress_trace(name, directory + "/stress.trace");
    Read read;
    TraceReader reader(directory + "/stress.trace");
    read.header = reader.header();
    const OpaqueDepthTest test(read.header);
    std::vector<Fragment> chunk;
    while (reader.next(chunk))
        for (const Fragment& f : chunk) {
            // A row of the pixels that all have a thousand layers is enough.
            if (test.visible_samples(f, {}) == 0 || (name == "thin_media" && f.y != 0)) continue;
            read.fragments.push_back(f);
            read.negative = read.negative || f.r < 0 || f.g < 0 || f.b < 0;
        }
    std::filesystem::remove_all(directory);
    return read;
}

class VisibilityStress : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Traces, VisibilityStress,
                         testing::Values("coplanar", "deep_pixel", "opaque_tail", "extreme_alpha",
                                         "thin_media", "depth_ends", "non_finite", "single_fragment"),
                         [](const auto& trace) { return std::string(trace.param); });

TEST_P(VisibilityStress, EveryPixelIsANumber) {
    const Read trace = stress_trace(GetParam());
    for (const char* technique :
         {"a_buffer:", "a_buffer:resolve=iterative,", "a_buffer:overflow=blend_tail,", "opacity_map:",
          "opacity_map:composite=normalised,", "opacity_map:sums=slab,lookup=step,slices_format=float16,",
          "opacity_map:planes=deep,spacing=growing,bounds_format=float16,", "opacity_map:memory=variable,",
          "opacity_map:bounds=frame,", "fourier_map:", "fourier_map:clamp=off,composite=normalised,",
          "fourier_map:coefficients=31,guard=0.1,bounds_format=unorm16,", "fourier_map:memory=variable,",
          "fourier_map:bounds=frame,coefficients_format=unorm8,",
          "occupancy_map:", "occupancy_map:counts=slab,alpha=geometric,alpha_sum_format=float16,",
          "occupancy_map:alpha=constant,constant_alpha=1,composite=plain,"}) {
        // Ten thousand nodes at a pixel, each read ten thousand times.
        if (std::string(technique).find("iterative") != std::string::npos &&
            GetParam() == std::string("deep_pixel"))
            continue;
        for (const char* format : {"format=paper", "format=float32"}) {
            TestFrame frame(std::string(technique) + format, trace.header, 0, 200000, false);
            frame.draw(trace.fragments);
            for (const float channel : frame.image()) {
                ASSERT_TRUE(std::isfinite(channel)) << technique << format;
                ASSERT_TRUE(channel >= 0.0f || trace.negative) << technique << format << channel;
            }
        }
    }
}

}  // namespace
}  // namespace ropsim
