#include "rop/pixel_store.h"

#include <algorithm>
#include <array>
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
                       PixelConstant constant_of)
    : declaration_(declaration),
      trace_(trace),
      constant_of_(std::move(constant_of)),
      tiles_across_(tiles_across(trace.width)),
      pixel_words_(static_cast<std::size_t>(declaration.pixel_words) + (constant_of_ ? 1 : 0)),
      tiles_(static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(tiles_across(trace.height))) {
    for (const Surface& s : declaration.surfaces)
        if (s.layout != Layout::kPool)
            cleared_.insert(cleared_.end(), s.clear_words.begin(), s.clear_words.end());
    if (constant_of_) cleared_.push_back(0);
    CHECK(cleared_.size() == pixel_words_, "{} words for {}", cleared_.size(), pixel_words_);
    if (declaration.node_words > 0) pool_ = std::make_unique<NodePool>(declaration.node_words, pool_nodes);
}

PixelBackground PixelStore::background(int x, int y) const {
    PixelBackground background;
    background.samples = trace_.samples;
    background.mean = mean_background(x, y);
    for (int m = 0; m < trace_.samples; ++m)
        background.sample[static_cast<std::size_t>(m)] = sample_background(x, y, m);
    return background;
}

glm::vec3 PixelStore::mean_background(int x, int y) const {
    if (!trace_.opaque) return trace_.background;
    glm::vec3 sum(0.0f);
    for (int m = 0; m < trace_.samples; ++m) sum += sample_background(x, y, m);
    return sum / static_cast<float>(trace_.samples);
}

glm::vec3 PixelStore::sample_background(int x, int y, int sample) const {
    if (!trace_.opaque) return trace_.background;
    const auto* rgb = &trace_.opaque->rgb[3 * opaque_index(trace_, x, y, sample)];
    return {rgb[0], rgb[1], rgb[2]};
}

float PixelStore::opaque_depth(int x, int y, int sample) const {
    if (!trace_.opaque) return std::numeric_limits<float>::infinity();
    return trace_.opaque->depth[opaque_index(trace_, x, y, sample)];
}

std::uint32_t* PixelStore::touch(std::size_t tile) {
    ++touched_tiles_;
    tiles_[tile] = memory_.take(std::max(kTilePixels * pixel_words_, std::size_t{1}));
    const int x0 = static_cast<int>(tile % static_cast<std::size_t>(tiles_across_)) * kTileSize;
    const int y0 = static_cast<int>(tile / static_cast<std::size_t>(tiles_across_)) * kTileSize;
    for (int i = 0; i < kTilePixels; ++i) {
        const int x = std::min(x0 + i % kTileSize, trace_.width - 1);
        const int y = std::min(y0 + i / kTileSize, trace_.height - 1);
        initialise(&tiles_[tile][static_cast<std::size_t>(i) * pixel_words_], x, y);
    }
    return tiles_[tile];
}

void PixelStore::initialise(std::uint32_t* words, int x, int y) const {
    std::copy(cleared_.begin(), cleared_.end(), words);
    for (const Surface& s : declaration_.surfaces)
        if (s.layout != Layout::kPool && s.initial != Initial::kClear) initialise(s, words, x, y);
    if (constant_of_) words[pixel_words_ - 1] = constant_of_(x, y, mean_background(x, y));
}

void PixelStore::initialise(const Surface& surface, std::uint32_t* words, int x, int y) const {
    std::uint32_t* out = words + surface.first_word;
    if (surface.initial == Initial::kClear) {
        std::copy_n(cleared_.begin() + surface.first_word, surface.words, out);
        return;
    }
    for (int e = 0; e < surface.elements; ++e, out += surface.first_channels) {
        // Stored sample e lies at the place of spatial sample e mod M.
        const int sample = e % trace_.samples;
        if (surface.initial == Initial::kOpaqueDepth) {
            const int u = std::min(full_resolution(x, surface.scale), trace_.width - 1);
            const int v = std::min(full_resolution(y, surface.scale), trace_.height - 1);
            *out = stored_word(stored_value(surface.format, opaque_depth(u, v, sample)));
            continue;
        }
        const glm::vec3 color =
            surface.elements == 1 ? mean_background(x, y) : sample_background(x, y, sample);
        const auto value = stored_rgb(surface.format, std::array<float, 3>{color.r, color.g, color.b});
        std::ranges::transform(value, out, stored_word);
    }
}

void PixelStore::restore(std::span<const int> surfaces, std::span<const std::uint8_t> selected) {
    for (std::size_t tile = 0; tile < tiles_.size(); ++tile) {
        if (tiles_[tile] == nullptr || (!selected.empty() && selected[tile] == 0)) continue;
        const int x0 = static_cast<int>(tile % static_cast<std::size_t>(tiles_across_)) * kTileSize;
        const int y0 = static_cast<int>(tile / static_cast<std::size_t>(tiles_across_)) * kTileSize;
        for (int i = 0; i < kTilePixels; ++i) {
            const int x = std::min(x0 + i % kTileSize, trace_.width - 1);
            const int y = std::min(y0 + i / kTileSize, trace_.height - 1);
            std::uint32_t* words = &tiles_[tile][static_cast<std::size_t>(i) * pixel_words_];
            for (const int s : surfaces)
                initialise(declaration_.surfaces[static_cast<std::size_t>(s)], words, x, y);
        }
    }
}

void PixelStore::copy_pixel(int x, int y, std::vector<std::uint32_t>& words) const {
    words.resize(pixel_words_);
    const std::size_t tile =
        static_cast<std::size_t>(y / kTileSize) * static_cast<std::size_t>(tiles_across_) +
        static_cast<std::size_t>(x / kTileSize);
    if (tiles_[tile] == nullptr) {
        initialise(words.data(), x, y);
        return;
    }
    const auto pixel = static_cast<std::size_t>(y % kTileSize * kTileSize + x % kTileSize);
    std::copy_n(&tiles_[tile][pixel * pixel_words_], pixel_words_, words.data());
}

}  // namespace ropsim
