// A study of cache sizes for programs and for readers.
#pragma once

#include "analysis/cache_sizes.h"

#include <string>

namespace ropsim {

// One object with every number, "units" saying what each is in. Same inputs, same text.
std::string cache_sizes_json(const CacheSizes& study);
// One line a scene, technique and cache under a heading: the models without a cache, the caches, the ideal
// ones.
std::string cache_sizes_csv(const CacheSizes& study);
// Two tables a scene as aligned plain text: bytes a fragment by size, and what each doubling of an ideal
// cache saves; below them what was refused.
std::string cache_sizes_table(const CacheSizes& study);

// gnuplot's commands: a panel a scene, bytes a fragment over the size on logarithmic axes, the models without
// a cache on the left, one without end on the right. At least one run has results.
std::string cache_sizes_plot_script(const CacheSizes& study, const std::string& svg, const std::string& png);
// Writes DIRECTORY/cache-sizes.svg and .png, each atomically. Throws UserError when gnuplot is missing or
// fails.
void write_cache_sizes_plot(const CacheSizes& study, const std::string& directory);

}  // namespace ropsim
