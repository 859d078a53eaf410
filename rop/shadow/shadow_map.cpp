#include "rop/shadow/shadow_map.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <string_view>

namespace ropsim {

namespace {

const Surface* find_surface(const Declaration& declaration, std::string_view name) {
    const auto found = std::find_if(declaration.surfaces.begin(), declaration.surfaces.end(),
                                    [&](const Surface& s) { return s.name == name; });
    return found == declaration.surfaces.end() ? nullptr : &*found;
}

}  // namespace

StoredShadowMap stored_shadow_map(const Declaration& declaration, const StoreMap& stores,
                                  const TraceHeader& header) {
    const Surface* const depth = find_surface(declaration, "depth");
    const Surface* const total = find_surface(declaration, "total_alpha");
    CHECK(depth != nullptr, "a shadow map without depths");
    CHECK(header.samples == 1, "a light view of {} samples a pixel", header.samples);
    StoredShadowMap map;
    map.width = header.width;
    map.height = header.height;
    map.samples = depth->elements;
    const auto texels = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
    map.depths.reserve(texels * static_cast<std::size_t>(map.samples));
    const PixelWindow pixels(stores);
    std::vector<std::uint32_t> words;
    const auto real = [&](int word) { return std::bit_cast<float>(words[static_cast<std::size_t>(word)]); };
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            pixels.copy(x, y, words);
            for (int s = 0; s < map.samples; ++s)
                map.depths.push_back(real(depth->first_word + s * depth->first_channels));
            if (total != nullptr) map.total_alpha.push_back(1.0f - real(total->first_word));
        }
    }
    if (total != nullptr)
        map.opaque = header.opaque ? header.opaque->depth
                                   : std::vector<float>(texels, std::numeric_limits<float>::infinity());
    return map;
}

}  // namespace ropsim
