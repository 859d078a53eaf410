// early_termination: a fragment behind every stored sample changes nothing, so that asking one word first may
// cost bytes and never the image.
#include "tests/rop/pixel_moments.h"

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

std::uint64_t bytes_read(TestFrame& frame) {
    std::uint64_t bytes = 0;
    for (std::size_t s = 0; s < frame.declaration().surfaces.size(); ++s)
        bytes += frame.log().read_elements(s) *
                 static_cast<std::uint64_t>(frame.declaration().surfaces[s].element_bytes());
    return bytes;
}

struct Drawn {
    std::vector<float> image;
    std::uint64_t bytes = 0;       // read by the passes
    std::uint64_t terminated = 0;  // operations
};
Drawn drawn(const std::string& technique, const TraceHeader& header, std::span<const Fragment> fragments) {
    TestFrame frame(technique, header, 4, 1u << 20, /*record=*/false);
    frame.draw(fragments);
    Drawn result;
    result.bytes = bytes_read(frame);
    for (const char* name : {"saturated_write", "saturated_accumulate"})
        if (const int path = frame.declaration().path(name); path >= 0)
            result.terminated += frame.log().path_count(static_cast<std::size_t>(path));
    result.image = frame.image();
    return result;
}

class Terminated : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(
    Techniques, Terminated,
    testing::Values("stochastic:samples=8", "stochastic:masks=coin,samples=8",
                    "stochastic:depth_test=first,samples=8", "stochastic:correction=coverage,samples=8",
                    "stochastic:correction=coverage,passes=merged,samples=8",
                    "stochastic:method=depth_based,samples=8",
                    "stochastic:method=depth_based,passes=merged,samples=8",
                    "stochastic:method=depth_based,correction=none,depth_format=unorm24,samples=8",
                    "stochastic:method=depth_based,samples=16,hardware_samples=4", "laine_karras:samples=8",
                    "laine_karras:method=depth_based,samples=8",
                    "laine_karras:tracking=false,correction=coverage,samples=8",
                    "laine_karras:samples=16,hardware_samples=8"),
    [](const auto& setup) {
        std::string name = setup.param;
        std::erase_if(name, [](char c) { return std::isalnum(c) == 0; });
        return name;
    });

// Not a bit, over an opaque layer, with ties of depth, alphas of 0 and 1 and partial coverage.
TEST_P(Terminated, ImageIsTheSame) {
    Random random(121);
    for (const int spatial : {1, 4}) {
        if (spatial > 1 && GetParam().find("correction=none") != std::string::npos) continue;
        const TraceHeader header = test::opaque_header(24, 24, spatial, random);
        test::FragmentOptions options;
        options.count = std::size_t{24} * 24 * 12;
        const auto fragments = test::random_fragments(header, options, random);
        const Drawn plain = drawn(GetParam(), header, fragments);
        const Drawn early = drawn(GetParam() + ",early_termination=true", header, fragments);
        EXPECT_EQ(early.image, plain.image) << spatial;
        EXPECT_EQ(plain.terminated, 0u);
        EXPECT_GT(early.terminated, fragments.size() / 50) << "else the test says nothing";
    }
}

// Twelve nearly opaque layers: near to far fewer bytes are read, far to near more, for the word in front.
TEST_P(Terminated, ReadsLessFromNearToFar) {
    const TraceHeader header = test::header_of(32, 32);
    std::vector<Fragment> layers;
    for (std::uint32_t i = 0; i < 12; ++i)
        layers.push_back(test::fragment_at(0, 0, 0.1f + 0.05f * static_cast<float>(i), 0.9f,
                                           {static_cast<float>(i) / 12, 1, 0.5f}, i));
    const auto near_first = test::everywhere(header, layers);
    const Drawn plain = drawn(GetParam(), header, near_first);
    const Drawn early = drawn(GetParam() + ",early_termination=true", header, near_first);
    EXPECT_EQ(early.image, plain.image);
    EXPECT_LT(static_cast<double>(early.bytes), 0.7 * static_cast<double>(plain.bytes));
    EXPECT_GT(early.terminated, near_first.size() / 2);
}

// Also where pixels use different numbers of samples: those not used stay empty, so that nothing terminates
// in such pixels, and nothing is lost.
TEST(Termination, KeepsTheImageWithFewerSamplesInBrightPixels) {
    Random random(122);
    const TraceHeader header = test::opaque_header(24, 24, 1, random);
    test::FragmentOptions options;
    options.count = std::size_t{24} * 24 * 12;
    const auto fragments = test::random_fragments(header, options, random);
    for (const std::string method : {"basic", "depth_based"}) {
        const std::string technique = "stochastic:samples=8,bright_samples=4,dark_below=0.5,method=" + method;
        EXPECT_EQ(drawn(technique + ",early_termination=true", header, fragments).image,
                  drawn(technique, header, fragments).image);
    }
}

// The word in front is worth its bytes only where something is terminated: thin layers, and far to near in
// the one pass that writes.
TEST(Termination, CostsBytesWhereNothingTerminates) {
    const TraceHeader header = test::header_of(32, 32);
    std::vector<Fragment> layers;
    for (std::uint32_t i = 0; i < 12; ++i)
        layers.push_back(
            test::fragment_at(0, 0, 0.9f - 0.05f * static_cast<float>(i), 0.9f, {1, 1, 0.5f}, i));
    for (const std::string technique : {"stochastic:samples=8", "laine_karras:samples=8"}) {
        const auto far_first = test::everywhere(header, layers);
        const Drawn plain = drawn(technique, header, far_first);
        const Drawn early = drawn(technique + ",early_termination=true", header, far_first);
        EXPECT_EQ(early.terminated, 0u);
        EXPECT_EQ(early.image, plain.image);
        EXPECT_GE(early.bytes, plain.bytes + 4 * far_first.size());
    }
}

}  // namespace
}  // namespace ropsim
