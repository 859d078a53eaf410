// What the tests of conversions share: whole traces with their channels, as stored, written, read and
// compared.
#pragma once

#include "tests/traces/scratch.h"
#include "traces/generators.h"
#include "traces/trace.h"

#include <cstring>
#include <string>
#include <vector>

namespace ropsim {

inline void write_whole(const std::string& path, const TraceHeader& header, const FragmentChunk& content) {
    TraceWriter writer(path, header);
    writer.append(content);
    writer.finish();
}

inline void write_random(const std::string& path, const RandomFragments& options) {
    write_whole(path, random_header(options), random_chunk(options));
}

inline FragmentChunk read_raw(const std::string& path) {
    TraceReader reader(path);
    FragmentChunk all;
    FragmentChunk chunk;
    while (reader.next_raw(chunk)) {
        all.fragments.insert(all.fragments.end(), chunk.fragments.begin(), chunk.fragments.end());
        all.slopes.insert(all.slopes.end(), chunk.slopes.begin(), chunk.slopes.end());
        all.materials.insert(all.materials.end(), chunk.materials.begin(), chunk.materials.end());
    }
    return all;
}

template <typename T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

inline bool same_content(const FragmentChunk& a, const FragmentChunk& b) {
    return same_bits(a.fragments, b.fragments) && same_bits(a.slopes, b.slopes) &&
           same_bits(a.materials, b.materials);
}

inline std::string hash_of(const std::string& path) {
    return TraceReader(path).hash();
}

}  // namespace ropsim
