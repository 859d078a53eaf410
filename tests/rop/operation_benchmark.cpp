// Speed of the plain operations, fragments a second on one core, and of adaptive transparency's next to a
// loop written by hand for it: `benchmark_rop`.
#include "rop/format.h"
#include "rop/nodes/vector_insertion.h"
#include "tests/rop/benchmark_workload.h"

#include <benchmark/benchmark.h>

namespace ropsim {
namespace {

using test::TestFrame;

using test::seconds_of;
using test::workload;
constexpr int kSide = test::kWorkloadSide;

void operate(benchmark::State& state, const std::string& technique) {
    const auto& fragments = workload();
    const auto header = test::header_of(kSide, kSide);
    for ([[maybe_unused]] auto _ : state) {
        TestFrame frame(technique, header, 0, 1u << 20, false);
        state.SetIterationTime(seconds_of([&] { frame.draw(fragments); }));
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(fragments.size()));
}

// Adaptive transparency with 8 nodes, as one writes it for a processor: find the place, shift, remove.
constexpr int kNodes = 8;
struct HandWrittenPixel {
    float node[kNodes][2];  // depth, transmittance
    float color[4];
};

void hand_written_insert(HandWrittenPixel& pixel, const Fragment& f) {
    const float t = 1.0f - f.a;
    int at = 0;
    while (at < kNodes && pixel.node[at][0] < f.z) ++at;
    float before = at > 0 ? pixel.node[at - 1][1] : 1.0f;
    if (pixel.node[kNodes - 1][0] == 1e30f) {
        for (int i = kNodes - 1; i > at; --i) {
            pixel.node[i][0] = pixel.node[i - 1][0];
            pixel.node[i][1] = pixel.node[i - 1][1] * t;
        }
        pixel.node[at][0] = f.z;
        pixel.node[at][1] = before * t;
        return;
    }
    float z[kNodes + 1];
    float v[kNodes + 1];
    for (int i = 0; i < at; ++i) {
        z[i] = pixel.node[i][0];
        v[i] = pixel.node[i][1];
    }
    z[at] = f.z;
    v[at] = before * t;
    for (int i = at; i < kNodes; ++i) {
        z[i + 1] = pixel.node[i][0];
        v[i + 1] = pixel.node[i][1] * t;
    }
    int removed = 1;
    float least = (v[0] - v[1]) * (z[1] - z[0]);
    for (int i = 2; i <= kNodes; ++i) {
        const float error = (v[i - 1] - v[i]) * (z[i] - z[i - 1]);
        if (error < least) {
            least = error;
            removed = i;
        }
    }
    v[removed - 1] = v[removed];
    for (int i = 0; i < kNodes; ++i) {
        const int from = i < removed ? i : i + 1;
        pixel.node[i][0] = z[from];
        pixel.node[i][1] = v[from];
    }
}

void hand_written_composite(HandWrittenPixel& pixel, const Fragment& f) {
    float visibility = 1.0f;
    for (int i = 0; i < kNodes && pixel.node[i][0] < f.z; ++i) visibility = pixel.node[i][1];
    pixel.color[0] = round_to_float16(pixel.color[0] + visibility * f.r);
    pixel.color[1] = round_to_float16(pixel.color[1] + visibility * f.g);
    pixel.color[2] = round_to_float16(pixel.color[2] + visibility * f.b);
}

void clear_by_hand(std::vector<HandWrittenPixel>& pixels) {
    HandWrittenPixel cleared{};
    for (auto& node : cleared.node) {
        node[0] = 1e30f;
        node[1] = 1.0f;
    }
    pixels.assign(std::size_t{kSide} * kSide, cleared);
}

void by_hand(void (*operation)(HandWrittenPixel&, const Fragment&), std::vector<HandWrittenPixel>& pixels,
             const std::vector<Fragment>& fragments) {
    for (const Fragment& f : fragments) operation(pixels[static_cast<std::size_t>(f.y * kSide + f.x)], f);
}

bool equal(TestFrame& frame, const std::vector<HandWrittenPixel>& pixels) {
    for (int i = 0; i < kSide * kSide; ++i) {
        const auto words = frame.words(i % kSide, i / kSide);
        const HandWrittenPixel& pixel = pixels[static_cast<std::size_t>(i)];
        // NOLINTBEGIN(bugprone-suspicious-memory-comparison): bits are what is compared.
        for (std::size_t n = 0; n < kNodes; ++n) {
            if (std::memcmp(&words[n], &pixel.node[n][0], sizeof(float)) != 0) return false;
            if (std::memcmp(&words[kNodes + n], &pixel.node[n][1], sizeof(float)) != 0) return false;
        }
        if (std::memcmp(words.data() + std::ptrdiff_t{2} * kNodes, pixel.color, 3 * sizeof(float)) != 0)
            return false;
        // NOLINTEND(bugprone-suspicious-memory-comparison)
    }
    return true;
}

// Ratios of fragments a second, the plain operation's over the loop by hand's, pass by pass and one after the
// other each time: of the insertion four nodes at a time, of the composite, and of both. What comes with an
// operation (its input, its bytes, its path) is the plain operation's alone.
void adaptive_next_to_hand_written(benchmark::State& state) {
    const auto& fragments = workload();
    const auto header = test::header_of(kSide, kSide);
    std::vector<HandWrittenPixel> pixels;
    std::array<double, 2> plain{};
    std::array<double, 2> hand{};
    for ([[maybe_unused]] auto _ : state) {
        TestFrame frame("adaptive:nodes=8", header, 0, 1u << 20, false);
        clear_by_hand(pixels);
        double seconds = 0;
        for (const int pass : {0, 1}) {
            const auto k = static_cast<std::size_t>(pass);
            const double own = seconds_of([&] { frame.draw_pass(pass, fragments); });
            hand[k] += seconds_of([&] {
                by_hand(pass == 0 ? hand_written_insert : hand_written_composite, pixels, fragments);
            });
            plain[k] += own;
            seconds += own;
        }
        state.SetIterationTime(seconds);
        if (!equal(frame, pixels)) state.SkipWithError("the loop by hand computes something else");
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(fragments.size()));
    state.counters["insertion_ratio"] = hand[0] / plain[0];
    state.counters["composite_ratio"] = hand[1] / plain[1];
    state.counters["ratio"] = (hand[0] + hand[1]) / (plain[0] + plain[1]);
}

#if defined(__SSE2__)
// The insertion alone on bare arrays, four nodes at a time, next to the loop by hand.
void insertion_on_arrays(benchmark::State& state) {
    const auto& fragments = workload();
    struct Nodes {
        std::array<std::uint32_t, kNodes> depth, transmittance;
    };
    Nodes cleared{};
    cleared.depth.fill(std::bit_cast<std::uint32_t>(1e30f));
    cleared.transmittance.fill(std::bit_cast<std::uint32_t>(1.0f));
    std::vector<HandWrittenPixel> pixels;
    double vector = 0;
    double hand = 0;
    for ([[maybe_unused]] auto _ : state) {
        std::vector<Nodes> nodes(std::size_t{kSide} * kSide, cleared);
        clear_by_hand(pixels);
        const double seconds = seconds_of([&] {
            for (const Fragment& f : fragments) {
                Nodes& n = nodes[static_cast<std::size_t>(f.y * kSide + f.x)];
                insert_four_at_a_time<kNodes / 4>(n.depth.data(), n.transmittance.data(), f.z, 1.0f - f.a,
                                                  1e30f);
            }
        });
        hand += seconds_of([&] { by_hand(hand_written_insert, pixels, fragments); });
        vector += seconds;
        state.SetIterationTime(seconds);
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(fragments.size()));
    state.counters["ratio"] = hand / vector;
}
#endif

[[maybe_unused]] const bool registered = [] {
    for (const TechniqueInfo& t : technique_list()) {
        std::string text(t.name);
        if (!t.headline_parameters.empty()) text.append(":").append(t.headline_parameters);
        benchmark::RegisterBenchmark(text.c_str(), operate, text)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
    }
    benchmark::RegisterBenchmark("adaptive:nodes=8/next_to_hand_written", adaptive_next_to_hand_written)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
#if defined(__SSE2__)
    benchmark::RegisterBenchmark("adaptive_insertion_on_arrays/next_to_hand_written", insertion_on_arrays)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
#endif
    return true;
}();

}  // namespace
}  // namespace ropsim
