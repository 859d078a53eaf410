#include "rop/pixel_store.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

namespace ropsim {
namespace {

std::size_t opaque_index(const TraceHeader& trace, int x, int y, int sample) {
    const std::size_t pixel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(trace.width) + static_cast<std::size_t>(x);
    return pixel * static_cast<std::size_t>(trace.samples) + static_cast<std::size_t>(sample);
}

}  // namespace

PixelStore::PixelStore(const Declaration& declaration, const TraceHeader& trace, std::uint64_t pool_nodes,
                       std::function<std::uint32_t(int, int)> constant_of)
    : declaration_(declaration),
      trace_(trace),
      constant_of_(std::move(constant_of)),
      tiles_across_(tiles_across(trace.width)),
      pixel_words_(static_cast<std::size_t>(declaration.pixel_words) + 1),
      tiles_(static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(tiles_across(trace.height))) {
    for (const Surface& s : declaration.surfaces)
        for (int e = 0; s.layout != Layout::kPool && e < s.elements; ++e)
            cleared_.insert(cleared_.end(), s.clear_words.begin(), s.clear_words.end());
    cleared_.push_back(0);
    CHECK(cleared_.size() == pixel_words_, "{} words for {}", cleared_.size(), pixel_words_);
    if (declaration.node_words > 0) pool_ = std::make_unique<NodePool>(declaration.node_words, pool_nodes);
}

glm::vec3 PixelStore::background(int x, int y) const {
    if (!trace_.opaque) return trace_.background;
    glm::vec3 sum(0.0f);
    for (int m = 0; m < trace_.samples; ++m) sum += sample_background(x, y, m);
    return sum / static_cast<float>(trace_.samples);
}

glm::vec3 PixelStore::sample_background(int x, int y, int sample) const {
    if (!trace_.opaque) return trace_.background;
    const float* rgb = &trace_.opaque->rgb[3 * opaque_index(trace_, x, y, sample)];
    return {rgb[0], rgb[1], rgb[2]};
}

float PixelStore::opaque_depth(int x, int y, int sample) const {
    if (!trace_.opaque) return std::numeric_limits<float>::infinity();
    return trace_.opaque->depth[opaque_index(trace_, x, y, sample)];
}

std::uint32_t* PixelStore::touch(std::size_t tile) {
    ++touched_tiles_;
    tiles_[tile] = std::make_unique_for_overwrite<std::uint32_t[]>(kTilePixels * pixel_words_);
    const int x0 = static_cast<int>(tile % static_cast<std::size_t>(tiles_across_)) * kTileSize;
    const int y0 = static_cast<int>(tile / static_cast<std::size_t>(tiles_across_)) * kTileSize;
    for (int i = 0; i < kTilePixels; ++i) {
        const int x = std::min(x0 + i % kTileSize, trace_.width - 1);
        const int y = std::min(y0 + i / kTileSize, trace_.height - 1);
        initialise(&tiles_[tile][static_cast<std::size_t>(i) * pixel_words_], x, y);
    }
    return tiles_[tile].get();
}

void PixelStore::initialise(std::uint32_t* words, int x, int y) const {
    std::copy(cleared_.begin(), cleared_.end(), words);
    for (const Surface& s : declaration_.surfaces) {
        if (s.initial == Initial::kClear) continue;
        std::uint32_t* out = words + s.first_word;
        for (int e = 0; e < s.elements; ++e, out += s.words) {
            // Stored sample e lies at the place of spatial sample e mod M.
            const int sample = e % trace_.samples;
            if (s.initial == Initial::kOpaqueDepth) {
                *out = std::bit_cast<std::uint32_t>(stored_value(s.format, opaque_depth(x, y, sample)));
                continue;
            }
            const glm::vec3 color = s.elements == 1 ? background(x, y) : sample_background(x, y, sample);
            const auto value = std::bit_cast<std::array<std::uint32_t, 3>>(
                stored_rgb(s.format, {color.r, color.g, color.b}));
            std::copy_n(value.begin(), value.size(), out);
        }
    }
    if (constant_of_) words[pixel_words_ - 1] = constant_of_(x, y);
}

}  // namespace ropsim
