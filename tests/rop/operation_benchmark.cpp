// Speed of the plain operations, fragments a second on one core, and of adaptive transparency's next to a
// loop written by hand for it: `benchmark_rop`.
#include "rop/nodes/vector_insertion.h"
#include "tests/rop/benchmark_workload.h"
#include "tests/rop/hand_written.h"

#include <benchmark/benchmark.h>

namespace ropsim {
namespace {

using test::TestFrame;

using test::cleared_pixel;
using test::hand_written_composite;
using test::hand_written_insert;
using test::HandWrittenPixel;
using test::seconds_of;
using test::workload;
constexpr int kNodes = test::kHandWrittenNodes;
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

void clear_by_hand(std::vector<HandWrittenPixel>& pixels) {
    pixels.assign(std::size_t{kSide} * kSide, cleared_pixel());
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
