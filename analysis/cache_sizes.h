// Bytes on the DRAM pins against the size of the ROP caches, next to the papers' models that have none: one
// functional pass a technique and trace feeds the caches of all sizes.
#pragma once

#include "model/cache_sweep.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ropsim {

struct CacheSizesOptions {
    std::vector<std::string> traces;                            // files
    std::vector<std::string> techniques;                        // NAME[:key=value,...]
    std::vector<int> kibibytes = {4, 8, 16, 32, 64, 128, 256};  // of a partition
    std::string hardware = "desktop";
    std::vector<std::string> settings;  // key=value
    std::uint64_t seed = 0;
    int threads = 0;  // of each run; 0: the cores are shared out among the runs at a time
};

// A technique on a scene. Bytes are those of the whole frame: depth test, initial copies, every pass,
// resolve, the image.
struct CacheSizesRun {
    std::string technique;
    std::string failure;        // why there are no results; empty: there are
    ReadWriteBytes worst_case;  // every operation on its costliest control path, no cache
    ReadWriteBytes touched;     // what the operations of this trace asked for, no cache
    ReadWriteBytes uncached;    // the same in whole bursts, each quad for itself
    std::vector<std::string> surfaces;
    CacheSweep sweep;
    std::uint64_t tile_bytes = 0;  // of a tile in all surfaces but pools that the run moved bytes of

    ReadWriteBytes pins(std::size_t size) const;   // of sweep.caches[size]
    ReadWriteBytes ideal(std::size_t size) const;  // of sweep.ideal[size]
    ReadWriteBytes floor() const { return ideal(sweep.ideal.size() - 1); }
    // What the ideal cache of this many bytes moves; it is one of those swept (CHECK).
    ReadWriteBytes ideal_of(std::uint64_t size_bytes) const;
    // Of the bytes that an ideal cache without end saves over `uncached`, the share that one of at most
    // `size_bytes` saves; none when nothing is saved.
    std::optional<double> saved_share(std::uint64_t size_bytes) const;
    // Smallest of the sizes with at most 5% more bytes on the pins than the largest; bytes.
    std::uint64_t near_largest() const;
    // Smallest ideal size with at most 5% more bytes than one without end; bytes, none: larger than those
    // swept.
    std::optional<std::uint64_t> near_floor() const;
    // Smallest ideal size that saves half of what can be saved; as near_floor().
    std::optional<std::uint64_t> half_saved() const;
};

struct CacheSizesScene {
    std::string trace, name, scene, hash;
    int width = 0, height = 0, samples = 1;
    std::uint64_t fragments = 0;
    std::vector<CacheSizesRun> runs;  // by technique

    double per_fragment(const ReadWriteBytes& bytes) const {
        return static_cast<double>(bytes.sum()) / static_cast<double>(fragments);
    }
};

struct CacheSizes {
    CacheSizesOptions options;  // kibibytes ascending
    std::uint32_t partitions = 0, partition_tiles = 0, ways = 0, line_bytes = 0, sector_bytes = 0;
    std::uint64_t burst_bytes = 0;
    std::vector<CacheSizesScene> scenes;
};

// Refuses what cannot be run: a trace that cannot be read or has no fragments, a technique that is unknown,
// given twice or refuses every trace, a size that the cache cannot have or that stands twice, a hardware key
// that is unknown or is the size. Throws UserError.
void check_cache_sizes(const CacheSizesOptions& options);

// Runs everything, with progress on stderr. Throws UserError as check_cache_sizes(), and for a faulty trace.
CacheSizes run_cache_sizes(const CacheSizesOptions& options);

}  // namespace ropsim
