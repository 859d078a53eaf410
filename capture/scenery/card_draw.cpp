// Cards as draws.
#include "capture/scenery/card_draw.h"

#include "base/random.h"
#include "capture/shader_sources.h"

#include <cstring>
#include <utility>

namespace ropsim {
namespace {

SceneDraw card_draw(const std::string& name, const std::vector<Card>& cards, SceneTexture texture,
                    const Daylight& daylight, const char* shading) {
    SceneDraw draw;
    draw.state.name = name;
    const std::string light(shader_source("daylight"));
    draw.vertex = light + std::string(shader_source("scenery_card_vertex"));
    draw.shading = light + std::string(shader_source(shading));
    draw.primitives = static_cast<std::uint32_t>(2 * cards.size());
    draw.parameters = daylight_parameters(daylight);
    draw.textures.push_back(std::move(texture));
    SceneBuffer buffer{1, std::vector<float>(16 * cards.size())};
    if (!cards.empty()) std::memcpy(buffer.values.data(), cards.data(), cards.size() * sizeof(Card));
    draw.buffers.push_back(std::move(buffer));
    return draw;
}

}  // namespace

SceneDraw cutout_draw(const std::string& name, const std::vector<Card>& cards, SceneTexture texture,
                      const Daylight& daylight, bool fades) {
    SceneDraw draw = card_draw(name, cards, std::move(texture), daylight, "scenery_cutout_shading");
    draw.parameters.emplace_back(0, fades ? 1 : 0, 0, 0);
    return draw;
}

SceneDraw smoke_draw(const std::string& name, const std::vector<Card>& cards, SceneTexture texture,
                     const Daylight& daylight, float roundness) {
    SceneDraw draw = card_draw(name, cards, std::move(texture), daylight, "scenery_smoke_shading");
    draw.parameters.emplace_back(roundness, 0, 0, 0);
    return draw;
}

void shuffle_cards(std::vector<Card>& cards, std::uint64_t seed) {
    for (std::size_t i = cards.size(); i > 1; --i) {
        const float pick = random_unit(mix64(seed ^ (0x53687566ull << 32)), static_cast<std::uint32_t>(i));
        std::swap(cards[i - 1], cards[static_cast<std::size_t>(pick * static_cast<float>(i))]);
    }
}

}  // namespace ropsim
