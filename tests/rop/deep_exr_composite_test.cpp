// A production deep image, imported in every arrival order, composites to what OpenEXR flattens it to.
#include "base/error.h"
#include "rop/reference.h"
#include "tests/traces/scratch.h"
#include "traces/interchange/deep_exr.h"

#include <array>
#include <cstdlib>
#include <filesystem>

#include <ImfCompositeDeepScanLine.h>
#include <ImfDeepCompositing.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using Composite = ScratchTest;

std::string production_image() {
    const char* directory = std::getenv("ROPSIM_DATA");
    const std::filesystem::path base =
        directory != nullptr ? directory
                             : std::filesystem::path(ROPSIM_SOURCE_DIR) / ".." / "shared" / "data";
    return (base / "weta-trunks-deep.exr").string();
}

// OpenEXR sorts the samples of a pixel only where several files contribute; this always sorts.
class SortedCompositing : public Imf::DeepCompositing {
 public:
    void composite_pixel(float outputs[], const float* inputs[], const char* channel_names[],
                         int num_channels, int num_samples, int /*sources*/) override {
        DeepCompositing::composite_pixel(outputs, inputs, channel_names, num_channels, num_samples, 2);
    }
};

Image flattened(const std::string& path) {
    Imf::DeepScanLineInputFile file(path.c_str());
    const Imath::Box2i window = file.header().dataWindow();
    Image image(window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, {"R", "G", "B", "A"});
    Imf::FrameBuffer frame;
    const std::size_t pixel_bytes = 4 * sizeof(float);
    for (std::size_t c = 0; c < 4; ++c)
        frame.insert(
            image.channels[c],
            Imf::Slice::Make(Imf::FLOAT, image.values.data() + c, window.min, image.width, image.height,
                             pixel_bytes, pixel_bytes * static_cast<std::size_t>(image.width)));
    SortedCompositing compositing;
    Imf::CompositeDeepScanLine composite;
    composite.setCompositing(&compositing);
    composite.addSource(&file);
    composite.setFrameBuffer(frame);
    composite.readPixels(window.min.y, window.max.y);
    return image;
}

TEST_F(Composite, OfAProductionDeepImageIsOpenExrsInEveryOrder) {
    const std::string file = production_image();
    if (!std::filesystem::exists(file))
        GTEST_SKIP() << file << " is not there; name the directory of weta-trunks-deep.exr in ROPSIM_DATA";
    const Image expected = flattened(file);
    for (const DeepOrder order :
         {DeepOrder::kFile, DeepOrder::kNearToFar, DeepOrder::kFarToNear, DeepOrder::kShuffle}) {
        import_deep_exr(file, path("t"), {order, 11});
        TraceReader trace(path("t"));
        const Image exact = reference_image(trace, 2);
        ASSERT_EQ(exact.width, expected.width);
        ASSERT_EQ(exact.height, expected.height);
        float largest = 0;
        double light = 0;
        for (int y = 0; y < exact.height; ++y)
            for (int x = 0; x < exact.width; ++x)
                for (std::size_t c = 0; c < 4; ++c) {
                    const float a = exact.pixel(x, y)[exact.channel(expected.channels[c])];
                    largest = std::max(largest, std::abs(a - expected.pixel(x, y)[c]));
                    light += static_cast<double>(a);
                }
        EXPECT_LE(largest, 1e-5f) << static_cast<int>(order);
        EXPECT_GT(light, 1000);  // there is a picture
    }
}

}  // namespace
}  // namespace ropsim
