// One technique on one pixel's fragments.
#include "analysis/pixel_run.h"

#include "analysis/standard_techniques.h"
#include "base/error.h"
#include "rop/operation_log.h"
#include "rop/pass_sequence.h"
#include "rop/registry.h"
#include "traces/depth_test.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Enough for any technique that takes a few nodes a fragment.
std::uint64_t pool_nodes(std::size_t fragments) {
    return 1024 + 4 * static_cast<std::uint64_t>(fragments);
}

std::size_t tile_of(const TraceHeader& header, int x, int y) {
    return static_cast<std::size_t>(y / kTileSize) * static_cast<std::size_t>(tiles_across(header.width)) +
           static_cast<std::size_t>(x / kTileSize);
}

// Calls take(fragment with the coverage that is to be seen, slope) for every fragment of the selected tiles.
template <class Take>
void for_visible(TraceReader& trace, Take take) {
    const OpaqueDepthTest test(trace.header());
    FragmentChunk chunk;
    trace.rewind();
    while (trace.next(chunk, kSlopeChannels | kLeastAlpha)) {
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const DepthSlope slope = chunk.slopes.empty() ? DepthSlope{} : chunk.slopes[i];
            Fragment f = chunk.fragments[i];
            f.coverage = static_cast<std::uint16_t>(test.visible_samples(f, slope));
            take(f, slope);
        }
    }
    trace.select_tiles({});
    trace.rewind();
}

}  // namespace

PixelPlace parse_pixel_place(const std::string& text, const std::string& where) {
    PixelPlace place;
    const char* const end = text.data() + text.size();
    const auto [comma, x_error] = std::from_chars(text.data(), end, place.x);
    if (x_error == std::errc() && comma != end && *comma == ',') {
        const auto [rest, y_error] = std::from_chars(comma + 1, end, place.y);
        if (y_error == std::errc() && rest == end && place.x >= 0 && place.y >= 0) return place;
    }
    throw UserError(where, fmt::format("'{}' is not X,Y: a pixel from the top left, e.g. 640,360", text));
}

std::vector<PixelFragments> read_pixels(TraceReader& trace, std::span<const PixelPlace> places) {
    const TraceHeader& header = trace.header();
    std::vector<std::uint8_t> selected(trace.tile_fragments().size(), 0);
    std::map<PixelPlace, std::size_t> index;
    std::vector<PixelFragments> pixels;
    for (const auto& [x, y] : places) {
        CHECK(x >= 0 && y >= 0 && x < header.width && y < header.height, "{},{}", x, y);
        CHECK(index.emplace(PixelPlace{x, y}, pixels.size()).second, "{},{} twice", x, y);
        selected[tile_of(header, x, y)] = 1;
        pixels.push_back({x, y, {}, {}, 0});
    }
    trace.select_tiles(std::move(selected));
    for_visible(trace, [&](const Fragment& f, const DepthSlope& slope) {
        const auto found = index.find({f.x, f.y});
        if (found == index.end()) return;
        PixelFragments& pixel = pixels[found->second];
        if (f.coverage == 0) {
            ++pixel.hidden;
            return;
        }
        pixel.fragments.push_back(f);
        pixel.slopes.push_back(slope);
    });
    return pixels;
}

PixelFragments read_pixel(TraceReader& trace, int x, int y) {
    const PixelPlace place{x, y};
    return std::move(read_pixels(trace, {&place, 1}).front());
}

DeepestPixel deepest_pixel(TraceReader& trace) {
    const auto width = static_cast<std::size_t>(trace.header().width);
    std::vector<std::uint32_t> counts(width * static_cast<std::size_t>(trace.header().height), 0);
    for_visible(trace, [&](const Fragment& f, const DepthSlope&) {
        if (f.coverage != 0) ++counts[f.y * width + f.x];
    });
    const auto deepest =
        static_cast<std::size_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
    return {static_cast<int>(deepest % width), static_cast<int>(deepest / width), counts[deepest]};
}

PixelRun::PixelRun(const TraceHeader& header, const PixelFragments& pixel, const std::string& technique,
                   std::uint64_t seed)
    : x_(pixel.x), y_(pixel.y) {
    TechniqueSpec spec = parse_technique(technique, "--technique");
    operation_ = make_operation(spec, screen_of(header, seed));
    store_ = std::make_unique<PixelStore>(operation_->declaration(), header,
                                          pool_nodes(pixel.fragments.size()), operation_->pixel_constant());
    run_passes(header, pixel);
}

void PixelRun::run_passes(const TraceHeader& header, const PixelFragments& pixel) {
    const Declaration& declaration = operation_->declaration();
    std::vector<std::uint32_t> operated;
    for (std::uint32_t i = 0; i < pixel.fragments.size(); ++i) {
        const Fragment& f = pixel.fragments[i];
        const bool nothing = f.a == 0.0f && f.r == 0.0f && f.g == 0.0f && f.b == 0.0f;
        if (!nothing || !declaration.zero_alpha_harmless) operated.push_back(i);
    }
    const auto tiles = static_cast<std::size_t>(tiles_across(header.width)) *
                       static_cast<std::size_t>(tiles_across(header.height));
    const StoreMap stores(header.width, header.height, std::vector<const PixelStore*>(tiles, store_.get()));
    OperationLog log(declaration, false);
    PassSequence sequence(declaration);
    while (!sequence.done()) {
        const Pass& pass = sequence.current();
        if (sequence.round() > 0) store_->restore(pass.restores);
        if (pass.kind == PassKind::kImage)
            operation_->image_pass(sequence.pass(), sequence.round(), *store_, stores, x_ / kTileSize,
                                   y_ / kTileSize, log);
        else
            operation_->run(sequence.pass(), sequence.round(), {pixel.fragments, pixel.slopes}, operated,
                            *store_, log);
        const int watched = sequence.watched_path();
        sequence.advance(watched < 0 ? 0 : log.path_count(static_cast<std::size_t>(watched)));
    }
}

std::vector<float> PixelRun::visibility(std::span<const float> depths) {
    std::vector<float> values(depths.size());
    operation_->visibility(*store_, x_, y_, depths, values);
    return values;
}

}  // namespace ropsim
