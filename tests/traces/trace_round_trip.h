// What the tests of trace files share: a rich trace, writing and reading it whole, comparing bit for bit.
#pragma once

#include "traces/generators.h"
#include "traces/trace.h"

#include <cstring>
#include <string>
#include <vector>

namespace ropsim {

inline bool same_bytes(const std::vector<Fragment>& a, const std::vector<Fragment>& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Fragment)) == 0);
}

inline std::vector<Fragment> read_all(TraceReader& reader) {
    std::vector<Fragment> all;
    std::vector<Fragment> chunk;
    reader.rewind();
    while (reader.next(chunk)) all.insert(all.end(), chunk.begin(), chunk.end());
    return all;
}

inline void write(const std::string& path, const TraceHeader& header, const std::vector<Fragment>& fragments,
                  const TraceLayoutOptions& layout) {
    TraceWriter writer(path, header, layout);
    writer.append(fragments);
    writer.finish();
}

inline RandomFragments rich_options() {
    RandomFragments options;
    options.width = 300;  // more than two regions, not a multiple of anything
    options.height = 141;
    options.samples = 8;
    options.partial_coverage = true;
    options.count = 20000;
    options.draws = 5;
    options.opaque = true;
    return options;
}

}  // namespace ropsim
