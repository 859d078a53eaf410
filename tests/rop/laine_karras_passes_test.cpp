// Laine and Karras's samples feeding the passes of Enderton et al. 2011: "combining the multi-pass methods
// ... should improve the results as in the original paper. Quantifying the improvement remains an interesting
// task" (Laine and Karras 2011, section 6).
#include "tests/rop/pixel_moments.h"

namespace ropsim {
namespace {

using test::Random;

constexpr int kSide = 64;

struct Scene {
    TraceHeader header;
    std::vector<Fragment> fragments;
    std::vector<double> exact;
};
// Three fragments a pixel at first, then six; every other scene of one alpha.
Scene random_scene(int number, Random& random) {
    Scene scene{test::opaque_header(kSide, kSide, 1, random), {}, {}};
    test::FragmentOptions options;
    options.count = static_cast<std::size_t>(kSide * kSide * (number < 2 ? 3 : 6));
    options.distinct_depths = true;
    options.extremes = false;
    scene.fragments = test::random_fragments(scene.header, options, random);
    for (Fragment& f : scene.fragments) {
        if (number % 2 == 0) continue;
        const float scale = 0.4f / f.a;
        f.r *= scale, f.g *= scale, f.b *= scale;
        f.a = 0.4f;
    }
    for (int i = 0; i < kSide * kSide; ++i) {
        const auto c = test::composited(scene.fragments, i % kSide, i / kSide,
                                        test::background_of(scene.header, i % kSide, i / kSide));
        scene.exact.insert(scene.exact.end(), c.begin(), c.end());
    }
    return scene;
}
double error_of(const std::string& technique, const Scene& scene) {
    const auto image = test::image_of(technique, scene.header, scene.fragments, 3);
    double sum = 0;
    for (std::size_t i = 0; i < image.size(); ++i) sum += std::pow(image[i] - scene.exact[i], 2);
    return std::sqrt(sum / static_cast<double>(image.size()));
}

// The improvement is that of the basic method, in every estimate: measured, an error of .81 to .91 of
// stochastic's at 8 samples, .67 to .76 at 16, .54 to .67 at 32.
TEST(StratifiedPasses, ErrorIsBelowThatOfRandomMasks) {
    Random random(91);
    for (int number = 0; number < 4; ++number) {
        const Scene scene = random_scene(number, random);
        for (const char* method :
             {"", ",correction=coverage", ",method=depth_based,correction=none", ",method=depth_based"})
            for (const auto& [samples, limit] : {std::pair(8, 0.95), {16, 0.82}, {32, 0.72}}) {
                const std::string options = ":format=float32,samples=" + std::to_string(samples) + method;
                EXPECT_LT(error_of("laine_karras" + options, scene),
                          limit * error_of("stochastic" + options, scene))
                    << number << options;
            }
    }
}

// Correction is worth as much as with random masks: less than half of the basic method's error.
TEST(StratifiedPasses, CorrectionImprovesAsInTheOriginalPaper) {
    Random random(92);
    for (int number = 0; number < 4; ++number) {
        const Scene scene = random_scene(number, random);
        for (const char* technique : {"laine_karras:format=float32", "stochastic:format=float32"})
            EXPECT_LT(error_of(technique + std::string(",method=depth_based"), scene),
                      0.65 * error_of(technique, scene))
                << technique;
    }
}

// One layer is exact in every pixel: visibility 1, U1 = alpha.
TEST(StratifiedPasses, OneLayerIsExact) {
    Random random(93);
    const TraceHeader header = test::opaque_header(kSide, kSide, 1, random);
    test::FragmentOptions options;
    options.count = std::size_t{kSide} * kSide * 3 / 4;
    options.most_in_a_pixel = 1;
    const auto fragments = test::random_fragments(header, options, random);
    for (const char* technique :
         {"laine_karras:method=depth_based,format=float32", "stochastic:method=depth_based,format=float32",
          "laine_karras:method=depth_based,format=float32,samples=16,hardware_samples=4",
          "laine_karras:method=depth_based,format=float32,passes=merged"}) {
        test::TestFrame frame(technique, header);
        frame.draw(fragments);
        EXPECT_LT(test::worst_error(frame, fragments), 1e-6) << technique;
    }
    // Where no pixel of it is empty, basic correction is, too.
    std::vector<Fragment> visible;
    for (const Fragment& f : fragments)
        if (f.a >= 1.0f / 16) visible.push_back(f);
    test::TestFrame frame("laine_karras:correction=coverage,format=float32,samples=16", header);
    frame.draw(visible);
    EXPECT_LT(test::worst_error(frame, visible), 1e-6);
}

}  // namespace
}  // namespace ropsim
