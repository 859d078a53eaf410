// Cuts a smaller trace out of a trace: by screen region, tiles, draws, or number.
#include "traces/trace_cut.h"

#include "base/error.h"
#include "traces/trace.h"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <string_view>

namespace ropsim {

namespace {

constexpr const char* kRegionForm = "write --region X,Y,WIDTHxHEIGHT, e.g. 100,50,64x32";

void check_region(const CutRegion& r, const TraceHeader& header, const std::string& path) {
    if (r.x < 0 || r.y < 0 || r.width < 1 || r.height < 1 || r.width > header.width - r.x ||
        r.height > header.height - r.y)
        throw UserError("--region", fmt::format("{},{},{}x{} does not lie inside the {}x{} pixels of {}", r.x,
                                                r.y, r.width, r.height, header.width, header.height, path));
}

// Row after row shifted by about 0.618 n tiles, the golden section: a lattice without stripes.
int lattice_shift(int n) {
    int shift = static_cast<int>((std::int64_t{n} * 618 + 500) / 1000);
    while (std::gcd(shift, n) != 1) ++shift;
    return shift;
}

std::vector<std::uint8_t> selected_tiles(const TraceHeader& header, const CutOptions& options) {
    const int across = tiles_across(header.width);
    const int down = tiles_across(header.height);
    const int shift = lattice_shift(options.every_nth_tile);
    const CutRegion whole{0, 0, header.width, header.height};
    const CutRegion region = options.region.value_or(whole);
    std::vector<std::uint8_t> selected;
    for (int row = 0; row < down; ++row)
        for (int column = 0; column < across; ++column) {
            const bool inside = (column + 1) * kTileSize > region.x && (row + 1) * kTileSize > region.y &&
                                column * kTileSize < region.x + region.width &&
                                row * kTileSize < region.y + region.height;
            const bool chosen = (column + std::int64_t{row} * shift) % options.every_nth_tile == 0;
            selected.push_back(inside && chosen ? 1 : 0);
        }
    return selected;
}

std::optional<std::uint32_t> number(std::string_view text) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
    return value;
}

// Marks what one item of the list means; a name that looks like a number is a number.
void mark_draws(std::string_view item, const std::vector<Draw>& draws, std::vector<std::uint8_t>& marked) {
    const auto dash = item.find('-');
    const auto first = number(item.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : number(item.substr(dash + 1));
    if (first && last) {
        if (*first > *last || *last >= draws.size())
            throw UserError("--draws", fmt::format("'{}': the trace has draws 0 to {}", item,
                                                   static_cast<std::int64_t>(draws.size()) - 1));
        std::fill(marked.begin() + *first, marked.begin() + *last + 1, std::uint8_t{1});
        return;
    }
    bool found = false;
    for (std::size_t i = 0; i < draws.size(); ++i) {
        if (draws[i].name != item) continue;
        marked[i] = 1;
        found = true;
    }
    if (!found)
        throw UserError("--draws",
                        fmt::format("'{}' is neither a number, a range A-B nor the name of a draw; "
                                    "'trace info' lists the draws",
                                    item));
}

std::vector<std::uint8_t> selected_draws(const TraceHeader& header, const std::string& list) {
    std::vector<std::uint8_t> marked(header.draws.size(), list.empty() ? 1 : 0);
    std::string_view rest = list;
    while (!rest.empty()) {
        const auto comma = rest.find(',');
        mark_draws(rest.substr(0, comma), header.draws, marked);
        rest = comma == std::string_view::npos ? std::string_view{} : rest.substr(comma + 1);
    }
    return marked;
}

}  // namespace

CutRegion parse_cut_region(const std::string& text) {
    CutRegion region;
    const char* at = text.data();
    const char* const end = text.data() + text.size();
    const auto take = [&](int& value, char behind) {
        const auto [next, error] = std::from_chars(at, end, value);
        const bool good =
            error == std::errc{} && (behind == 0 ? next == end : next != end && *next == behind);
        if (!good) throw UserError("--region", fmt::format("'{}': {}", text, kRegionForm));
        at = next + 1;
    };
    take(region.x, ',');
    take(region.y, ',');
    take(region.width, 'x');
    take(region.height, 0);
    return region;
}

void cut_trace(const std::string& trace_path, const std::string& out_path, const CutOptions& options) {
    CHECK(options.every_nth_tile >= 1, "{}", options.every_nth_tile);
    TraceReader reader(trace_path);
    const TraceHeader& header = reader.header();
    if (options.region) check_region(*options.region, header, trace_path);
    const std::vector<std::uint8_t> draws = selected_draws(header, options.draws);
    const CutRegion region = options.region.value_or(CutRegion{0, 0, header.width, header.height});
    const auto keeps = [&](const Fragment& f) {
        return draws[f.draw] != 0 && f.x >= region.x && f.y >= region.y && f.x < region.x + region.width &&
               f.y < region.y + region.height;
    };
    if (options.region || options.every_nth_tile > 1) {
        reader.select_tiles(selected_tiles(header, options));
        reader.rewind();
    }
    TraceWriter writer(out_path, header);
    std::uint64_t left = options.first.value_or(reader.fragment_count());
    FragmentChunk chunk;
    FragmentChunk kept;
    while (left != 0 && reader.next_raw(chunk)) {
        kept.clear();
        for (std::size_t i = 0; i < chunk.size() && left != 0; ++i) {
            if (!keeps(chunk.fragments[i])) continue;
            kept.fragments.push_back(chunk.fragments[i]);
            if (header.depth_slopes) kept.slopes.push_back(chunk.slopes[i]);
            if (header.materials) kept.materials.push_back(chunk.materials[i]);
            --left;
        }
        writer.append(kept);
    }
    writer.finish();
}

}  // namespace ropsim
