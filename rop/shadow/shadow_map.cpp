#include "rop/shadow/shadow_map.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <string_view>
#include <vector>

namespace ropsim {

namespace {

const Surface* find_surface(const Declaration& declaration, std::string_view name) {
    const auto found = std::find_if(declaration.surfaces.begin(), declaration.surfaces.end(),
                                    [&](const Surface& s) { return s.name == name; });
    return found == declaration.surfaces.end() ? nullptr : &*found;
}

// Calls work(x, y, words) with each texel's functional words, row by row.
template <typename Work>
void for_each_texel(const StoreMap& stores, const TraceHeader& header, const Work& work) {
    const PixelWindow pixels(stores);
    std::vector<std::uint32_t> words;
    for (int y = 0; y < header.height; ++y)
        for (int x = 0; x < header.width; ++x) {
            pixels.copy(x, y, words);
            work(words);
        }
}

float real_in(const std::vector<std::uint32_t>& words, int word) {
    return std::bit_cast<float>(words[static_cast<std::size_t>(word)]);
}

}  // namespace

StoredShadowMap stored_depths_of(const Declaration& declaration, const StoreMap& stores,
                                 const TraceHeader& header, std::string_view surface) {
    const Surface* const depth = find_surface(declaration, surface);
    CHECK(depth != nullptr, "a shadow map without '{}'", surface);
    CHECK(header.samples == 1, "a light view of {} samples a pixel", header.samples);
    StoredShadowMap map;
    map.width = header.width;
    map.height = header.height;
    map.samples = depth->elements;
    map.depths.reserve(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height) *
                       static_cast<std::size_t>(map.samples));
    for_each_texel(stores, header, [&](const std::vector<std::uint32_t>& words) {
        for (int s = 0; s < map.samples; ++s)
            map.depths.push_back(real_in(words, depth->first_word + s * depth->first_channels));
    });
    return map;
}

StoredShadowMap stored_shadow_map(const Declaration& declaration, const StoreMap& stores,
                                  const TraceHeader& header) {
    const Surface* const total = find_surface(declaration, "total_alpha");
    StoredShadowMap map = stored_depths_of(declaration, stores, header, "depth");
    if (total == nullptr) return map;
    for_each_texel(stores, header, [&](const std::vector<std::uint32_t>& words) {
        map.total_alpha.push_back(1.0f - real_in(words, total->first_word));
    });
    map.opaque = header.opaque
                     ? header.opaque->depth
                     : std::vector<float>(map.total_alpha.size(), std::numeric_limits<float>::infinity());
    return map;
}

}  // namespace ropsim
