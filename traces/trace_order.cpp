// Gives a trace's fragments another arrival order.
#include "traces/trace_order.h"

#include "base/error.h"
#include "base/random.h"
#include "traces/depth_key.h"
#include "traces/trace.h"
#include "traces/value_ranges.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace ropsim {

namespace {

constexpr std::size_t kPiece = 1u << 16;

struct Key {
    std::uint64_t value;
    std::uint32_t arrival;
    bool operator<(const Key& other) const {
        return value != other.value ? value < other.value : arrival < other.arrival;
    }
};

FragmentChunk read_everything(TraceReader& reader) {
    if (reader.fragment_count() >= std::uint64_t{1} << 32)
        throw UserError(reader.path(),
                        fmt::format("holds {} fragments; up to 2^32 - 1 can be sorted; cut it with "
                                    "'trace cut'",
                                    reader.fragment_count()));
    FragmentChunk all;
    FragmentChunk chunk;
    const auto count = static_cast<std::size_t>(reader.fragment_count());
    all.fragments.reserve(count);
    if (reader.header().depth_slopes) all.slopes.reserve(count);
    if (reader.header().materials) all.materials.reserve(count);
    while (reader.next_raw(chunk)) {
        all.fragments.insert(all.fragments.end(), chunk.fragments.begin(), chunk.fragments.end());
        all.slopes.insert(all.slopes.end(), chunk.slopes.begin(), chunk.slopes.end());
        all.materials.insert(all.materials.end(), chunk.materials.begin(), chunk.materials.end());
    }
    return all;
}

std::uint32_t depth_of(Fragment f) {
    bring_into_range(f);
    return depth_key(f.z);
}

// Random numbers by arrival. Among fragments of one pixel and depth they ascend.
std::vector<Key> shuffle_keys(const std::vector<Fragment>& fragments, std::uint64_t seed) {
    const std::uint64_t stream = mix64(seed + 0x9E3779B97F4A7C15ull);
    std::vector<Key> keys(fragments.size());
    for (std::uint32_t i = 0; i < keys.size(); ++i) {
        const Fragment& f = fragments[i];
        // Pixel and depth together; 14 bits a coordinate.
        keys[i] = {std::uint64_t{f.y} << 46 | std::uint64_t{f.x} << 32 | depth_of(f), i};
    }
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint64_t> random;
    for (std::size_t from = 0; from < keys.size();) {
        std::size_t to = from + 1;
        while (to < keys.size() && keys[to].value == keys[from].value) ++to;
        random.clear();
        for (std::size_t i = from; i < to; ++i) random.push_back(mix64(stream + keys[i].arrival));
        std::sort(random.begin(), random.end());
        for (std::size_t i = from; i < to; ++i) keys[i].value = random[i - from];
        from = to;
    }
    return keys;
}

std::uint64_t key_of(const Fragment& f, ArrivalOrder order, int tile_columns) {
    switch (order) {
        case ArrivalOrder::kNearToFar:
            return depth_of(f);
        case ArrivalOrder::kFarToNear:
            return ~depth_of(f);
        case ArrivalOrder::kPrimitive:
            return std::uint64_t{f.draw} << 32 | primitive_number(f);
        case ArrivalOrder::kTile:
            return static_cast<std::uint64_t>(f.y / kTileSize * tile_columns + f.x / kTileSize);
        case ArrivalOrder::kShuffle:
            break;
    }
    CHECK(false, "order {}", static_cast<int>(order));
    return 0;
}

std::vector<Key> order_keys(const FragmentChunk& all, ArrivalOrder order, std::uint64_t seed,
                            int tile_columns) {
    std::vector<Key> keys;
    if (order == ArrivalOrder::kShuffle) {
        keys = shuffle_keys(all.fragments, seed);
    } else {
        keys.reserve(all.size());
        for (std::uint32_t i = 0; i < all.size(); ++i)
            keys.push_back({key_of(all.fragments[i], order, tile_columns), i});
    }
    std::sort(keys.begin(), keys.end());
    return keys;
}

}  // namespace

void order_trace(const std::string& trace_path, const std::string& out_path, ArrivalOrder order,
                 std::uint64_t seed) {
    TraceReader reader(trace_path);
    const TraceHeader& header = reader.header();
    const FragmentChunk all = read_everything(reader);
    TraceWriter writer(out_path, header);
    FragmentChunk piece;
    for (const Key& key : order_keys(all, order, seed, tiles_across(header.width))) {
        piece.fragments.push_back(all.fragments[key.arrival]);
        if (header.depth_slopes) piece.slopes.push_back(all.slopes[key.arrival]);
        if (header.materials) piece.materials.push_back(all.materials[key.arrival]);
        if (piece.size() < kPiece) continue;
        writer.append(piece);
        piece.clear();
    }
    writer.append(piece);
    writer.finish();
}

}  // namespace ropsim
