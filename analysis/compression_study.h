// What lossless compression of blocks saves, by technique, surface and codec: one functional pass a technique
// and trace feeds machines without it and with each choice of codecs.
#pragma once

#include "model/compression_sweep.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

struct CompressionStudyOptions {
    std::vector<std::string> traces;      // files
    std::vector<std::string> techniques;  // NAME[:key=value,...]
    std::string hardware = "desktop";
    std::vector<std::string> settings;  // key=value
    int metadata_kibibytes = 4;         // a partition's metadata cache, of the last setup
    std::uint64_t seed = 0;
    int threads = 0;  // of each run; 0: the cores are shared out among the runs at a time
};

// Values of compression.depth, .color and .nodes, and of metadata.kibibytes.
struct CompressionSetup {
    std::array<std::string, 3> codecs;  // by SurfaceClass
    int metadata_kibibytes = 0;

    bool off() const { return codecs[0] == "none"; }
    // As --set takes them.
    std::vector<std::string> settings() const;
    std::string name() const;  // "planes/delta/used", "... + states"
};

// What is measured, in the order of every run's outcomes: nothing compressed; every codec once at least, with
// block states on chip; the codecs of the one before with states in memory. Codecs of one class do not change
// what another class moves (states and a second-level cache do), so three setups tell of all codecs.
std::vector<CompressionSetup> compression_setups(int metadata_kibibytes);

// On the pins, of the whole frame, bytes.
struct PinGroups {
    std::uint64_t fill = 0;   // reads for operations, copies, resolve and passes over the image
    std::uint64_t write = 0;  // write-backs and flush
    std::uint64_t repack = 0;
    std::uint64_t metadata = 0;  // both ways
    std::uint64_t sum() const { return fill + write + repack + metadata; }
    void add(const PinGroups& other);
};

// Of what `off` moves, the share that is not moved, negative where more is; 0 where nothing is moved.
double saved_share(const PinGroups& off, const PinGroups& on);

struct SurfaceOutcome {
    CompressionCounts blocks;  // without levels: nothing is compressed
    PinGroups pins;
};

// Bytes of the blocks that were tried over those they were stored in; 0 where none was.
double storage_ratio(const CompressionCounts& blocks);

struct StudiedSurface {
    std::string name;
    SurfaceClass surface_class = SurfaceClass::kColor;
    std::uint32_t element_bytes = 0;
    int elements = 0;                      // of a pixel; 0: a pool
    std::vector<SurfaceOutcome> outcomes;  // by setup
};

// A technique on a scene.
struct CompressionRun {
    std::string technique;
    std::string failure;                   // why there are no results; empty: there are
    std::vector<StudiedSurface> surfaces;  // those that a setup moves bytes of

    PinGroups pins(std::size_t setup) const;  // of all surfaces
};

struct CompressionScene {
    std::string trace, name, scene, hash;
    int width = 0, height = 0, samples = 1;
    std::uint64_t fragments = 0;
    std::vector<CompressionRun> runs;  // by technique
};

struct CompressionStudy {
    CompressionStudyOptions options;
    std::vector<CompressionSetup> setups;
    MachineConfig machine;  // of the last setup
    std::vector<CompressionScene> scenes;
};

// "depth", "color", "nodes".
const char* class_name(SurfaceClass surface_class);

// Refuses what cannot be run: a trace that cannot be read or has no fragments, a technique that is unknown,
// given twice or refuses every trace, a hardware key that is unknown or that the setups run through. Throws
// UserError.
void check_compression_study(const CompressionStudyOptions& options);

// Runs everything, with progress on stderr. Throws UserError as check_compression_study(), and for a faulty
// trace.
CompressionStudy run_compression_study(const CompressionStudyOptions& options);

}  // namespace ropsim
