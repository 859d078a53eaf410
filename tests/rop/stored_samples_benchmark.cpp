// Techniques of 16 stored samples next to loops written by hand for them: `benchmark_rop`.
#include "rop/format.h"
#include "rop/hilbert.h"
#include "tests/rop/benchmark_workload.h"

#include <benchmark/benchmark.h>

namespace ropsim {
namespace {

using test::seconds_of;
using test::TestFrame;
using test::workload;

constexpr int kSide = test::kWorkloadSide;
constexpr int kSamples = 16;

// Depth-based stochastic transparency with total alpha, as one writes it for a processor.
struct DepthBasedPixel {
    float depth[kSamples];
    float color[4];  // sums of colour and of weights
    float clear;     // product of transmittances
};

void total_alpha(DepthBasedPixel& pixel, const Fragment& f) {
    pixel.clear = round_to_float16(pixel.clear * (1.0f - f.a));
}

void stochastic_depth(DepthBasedPixel& pixel, const Fragment& f) {
    const std::uint64_t place = static_cast<std::uint64_t>(f.y) * kSide + f.x;
    const std::uint64_t key = mix64(mix64(f.draw) ^ (place << 32) ^ f.primitive);
    auto wanted = static_cast<std::uint32_t>(f.a * kSamples + random_unit(key, 0));
    for (std::uint32_t s = 0; s < kSamples && wanted > 0; ++s) {
        const std::uint32_t left = kSamples - s;
        if (wanted < left) {
            const std::uint64_t position = (std::uint64_t{random_bits(key, 1 + s)} * left) >> 32;
            if (position >= wanted) continue;
        }
        --wanted;
        if (f.z < pixel.depth[s]) pixel.depth[s] = f.z;
    }
}

void accumulate(DepthBasedPixel& pixel, const Fragment& f) {
    int count = 0;
    for (const float depth : pixel.depth) count += f.z <= depth ? 1 : 0;
    if (count == 0) return;
    const float visibility = static_cast<float>(count) / kSamples;
    pixel.color[0] = round_to_float16(pixel.color[0] + visibility * f.r);
    pixel.color[1] = round_to_float16(pixel.color[1] + visibility * f.g);
    pixel.color[2] = round_to_float16(pixel.color[2] + visibility * f.b);
    pixel.color[3] = round_to_float16(pixel.color[3] + visibility * f.a);
}

void depth_based_by_hand(std::vector<DepthBasedPixel>& pixels, const std::vector<Fragment>& fragments) {
    DepthBasedPixel cleared{{}, {}, 1.0f};
    std::fill_n(cleared.depth, kSamples, std::numeric_limits<float>::infinity());
    pixels.assign(std::size_t{kSide} * kSide, cleared);
    const auto at = [&](const Fragment& f) -> DepthBasedPixel& {
        return pixels[static_cast<std::size_t>(f.y * kSide + f.x)];
    };
    for (const Fragment& f : fragments) total_alpha(at(f), f);
    for (const Fragment& f : fragments) stochastic_depth(at(f), f);
    for (const Fragment& f : fragments) accumulate(at(f), f);
}

// Laine and Karras's Fig. 7.
struct LaineKarrasPixel {
    float depth[kSamples];
    float color[kSamples][4];
    std::uint32_t covered;
    std::uint32_t surface;
};

std::uint32_t reference(std::uint32_t index, std::uint32_t surface) {
    std::uint32_t x = reverse_bits(index) + surface;
    for (const std::uint32_t factor : {0x6C50B47Cu, 0xB82F1E52u, 0xC7AFE638u, 0x8D22F6E6u}) x ^= x * factor;
    return x;
}

void draw(LaineKarrasPixel& pixel, const Fragment& f, std::uint32_t index) {
    int order[kSamples];
    int count = 0;
    std::uint32_t mask = 0;
    for (int s = 0; s < kSamples; ++s) {
        if (f.z > pixel.depth[s]) continue;
        mask |= 1u << s;
        int at = count++;
        for (; at > 0 && pixel.depth[order[at - 1]] > pixel.depth[s]; --at) order[at] = order[at - 1];
        order[at] = s;
    }
    if (mask == 0) return;
    if ((mask & pixel.covered) != 0) {
        ++pixel.surface;
        pixel.covered = 0;
    }
    std::uint32_t n = index * kSamples + static_cast<std::uint32_t>(std::popcount(pixel.covered));
    pixel.covered |= mask;
    const auto threshold = static_cast<std::uint64_t>(std::ceil(static_cast<double>(f.a) * 0x1p32));
    const float inverse = f.a > 0 ? 1.0f / f.a : 0.0f;
    const float color[3] = {f.r * inverse, f.g * inverse, f.b * inverse};
    for (int k = 0; k < count; ++k, ++n) {
        if (reference(n, pixel.surface) >= threshold) continue;
        const int s = order[k];
        pixel.depth[s] = f.z;
        for (int c = 0; c < 3; ++c) pixel.color[s][c] = stored_value(Format::kUnorm8, color[c]);
    }
}

void laine_karras_by_hand(std::vector<LaineKarrasPixel>& pixels, const std::vector<Fragment>& fragments,
                          glm::vec3 background) {
    LaineKarrasPixel cleared{};
    for (int s = 0; s < kSamples; ++s) {
        cleared.depth[s] = std::numeric_limits<float>::infinity();
        for (int c = 0; c < 3; ++c) cleared.color[s][c] = stored_value(Format::kUnorm8, background[c]);
        cleared.color[s][3] = 1.0f;
    }
    pixels.assign(std::size_t{kSide} * kSide, cleared);
    std::vector<std::uint32_t> index;
    for (int i = 0; i < kSide * kSide; ++i)
        index.push_back(hilbert_index(hilbert_order(kSide, kSide), i % kSide, i / kSide));
    for (const Fragment& f : fragments) {
        const auto at = static_cast<std::size_t>(f.y * kSide + f.x);
        draw(pixels[at], f, index[at]);
    }
}

// ratio: fragments a second of the plain operation over those of the loop by hand, run one after the other
// each time. Both must leave the same words.
template <class Pixel, class ByHand>
void next_to_hand_written(benchmark::State& state, const std::string& technique, ByHand by_hand_loop) {
    const auto& fragments = workload();
    const auto header = test::header_of(kSide, kSide);
    std::vector<Pixel> pixels;
    double plain = 0;
    double by_hand = 0;
    for ([[maybe_unused]] auto _ : state) {
        TestFrame frame(technique, header, 0, 1u << 20, false);
        const double seconds = seconds_of([&] { frame.draw(fragments); });
        by_hand += seconds_of([&] { by_hand_loop(pixels, fragments); });
        plain += seconds;
        state.SetIterationTime(seconds);
        for (int i = 0; i < kSide * kSide; ++i)
            // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): bits are what is compared.
            if (std::memcmp(frame.words(i % kSide, i / kSide).data(), &pixels[static_cast<std::size_t>(i)],
                            sizeof(Pixel)) != 0)
                state.SkipWithError("the loop by hand computes something else");
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(fragments.size()));
    state.counters["by_hand_per_second"] =
        static_cast<double>(state.iterations()) * static_cast<double>(fragments.size()) / by_hand;
    state.counters["ratio"] = by_hand / plain;
}

void depth_based(benchmark::State& state) {
    next_to_hand_written<DepthBasedPixel>(state, "stochastic:samples=16,method=depth_based",
                                          depth_based_by_hand);
}
void laine_karras(benchmark::State& state) {
    next_to_hand_written<LaineKarrasPixel>(
        state, "laine_karras:samples=16", [](auto& pixels, const auto& fragments) {
            laine_karras_by_hand(pixels, fragments, test::header_of(1, 1).background);
        });
}
BENCHMARK(depth_based)
    ->Name("stochastic:samples=16,method=depth_based/next_to_hand_written")
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(laine_karras)
    ->Name("laine_karras:samples=16/next_to_hand_written")
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ropsim
