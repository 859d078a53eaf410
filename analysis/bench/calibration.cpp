// The loop, and the processor's clock of its thread.
#include "analysis/bench/calibration.h"

#include "base/random.h"

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <vector>

namespace ropsim {
namespace {

constexpr std::uint32_t kFragments = 4'000'000;
constexpr std::size_t kPixels = std::size_t{1} << 17;

struct Pixel {
    float red = 0, green = 0, blue = 0, transmittance = 1;
};

double thread_seconds() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

double calibration_seconds() {
    std::vector<Pixel> pixels(kPixels);
    const double before = thread_seconds();
    for (std::uint32_t i = 0; i < kFragments; ++i) {
        const std::uint64_t bits = mix64(i);
        Pixel& p = pixels[bits % kPixels];
        const float alpha = static_cast<float>(bits >> 56) * (1.0f / 512);
        const float color = alpha * p.transmittance;
        p.red += color * static_cast<float>((bits >> 48) & 255);
        p.green += color * static_cast<float>((bits >> 40) & 255);
        p.blue += color * static_cast<float>((bits >> 32) & 255);
        p.transmittance *= 1 - alpha;
    }
    const double seconds = thread_seconds() - before;
    // So that nothing was done for nobody.
    const volatile float last = pixels[kPixels / 2].red;
    static_cast<void>(last);
    return seconds;
}

}  // namespace ropsim
