// Error against bytes: every technique on several traces, and which of them no other beats in both.
#pragma once

#include "analysis/comparison.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ropsim {

// What errors are set against: bytes, or the frame's time.
// kPinsAndWorstCase: those on the pins, and beside them the worst case.
enum class TradeoffBytes : std::uint8_t { kTouched, kWorstCase, kPins, kFrameTime, kPinsAndWorstCase };

struct TradeoffOptions {
    std::vector<std::string> traces;                // files
    std::vector<std::string> techniques;            // NAME[:key=value,...]; empty: standard_techniques()
    std::vector<std::string> run_options;           // passed through to `ropsim run`
    TradeoffBytes bytes = TradeoffBytes::kTouched;  // pins: fidelity `cached`; time: `timed`; else `count`
    int threads = 0;                                // of each run; 0: the cores are shared out among the runs
    std::string directory;                          // each run keeps its run.json and image.png in DIR/runs
    bool keep_images = false;                       // and its image.exr
    std::string program;                            // that understands `run`; empty: this one
};

// What a technique cost and gave on a trace. Bytes are read and written ones of the whole frame (depth test,
// initial copies, every pass, resolve, the image), a fragment of the trace; but for pins, before caches.
struct TradeoffPoint {
    std::string failure;            // why there are no results; empty: there are
    bool broken = false;            // the run failed although the technique does not refuse the trace
    Measured operation_bytes;       // of one fragment at worst, all passes (worst_case_bytes of rop/cost.h);
                                    // empty where the technique refuses the trace
    Measured rmse8, rmse8_covered;  // as in rop/image_metrics.h
    Measured touched, worst_case;   // bytes a fragment; touched by this trace, and if every operation took
                                    // its costliest path
    Measured pins;                  // bytes a fragment on the DRAM bus, behind caches; not with `count`
    Measured frame_ms;              // simulated; not with `count`
    Measured storage_bits;          // a pixel, without the pool
    Measured node_bits;             // a node of the pool, one a fragment stored; empty without a pool
    Measured pool_bits;             // used, a pixel of the image
    Measured dropped;               // fragments that found the pool full
    bool fixed_front = false;       // the same among techniques whose memory is known beforehand: no pool
    bool front = false;             // no other technique on this trace has less of one of rmse8 and bytes
                                    // and no more of the other
};

struct TradeoffTechnique {
    std::string technique;          // as given
    std::size_t family = 0;         // of technique_families()
    std::vector<TradeoffPoint> at;  // by scene
};

struct TradeoffScene {
    std::string trace, name, scene, hash;
    int width = 0, height = 0, samples = 1;
    double fragments = 0;
};

struct Tradeoff {
    TradeoffOptions options;
    std::vector<TradeoffScene> scenes;
    std::vector<TradeoffTechnique> techniques;
};

// What is on the axis of bytes.
struct TradeoffBytesKind {
    const char* name;      // of --bytes
    const char* fidelity;  // of the runs
    Measured TradeoffPoint::*member;
    const char* axis;
    const char* column;                        // of a table
    std::optional<TradeoffBytes> beside = {};  // shown at the same error, with its own front
};
const TradeoffBytesKind& bytes_kind(TradeoffBytes bytes);

// Whether each technique is on the scene's front of error and these bytes, in their order.
std::vector<bool> scene_front(const Tradeoff& tradeoff, std::size_t scene, TradeoffBytes bytes);

// Refuses what cannot be run: a trace that cannot be read, a technique given twice, and one given by name
// that is unknown, misspelt, makes no colour image or refuses every trace. Throws UserError.
void check_tradeoff(const TradeoffOptions& options);

// Runs everything, one process a run, as many at a time as there are cores, with progress on stderr. A
// technique that refuses a trace is a point with its reason. Throws UserError as check_tradeoff.
Tradeoff run_tradeoff(const TradeoffOptions& options);

// The runs that failed without having refused their trace: "SCENE TECHNIQUE" each.
std::vector<std::string> broken_runs(const Tradeoff& tradeoff);

}  // namespace ropsim
