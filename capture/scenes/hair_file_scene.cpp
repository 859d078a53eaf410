// Scene: the strands of a .hair file.
#include "base/error.h"
#include "base/random.h"
#include "capture/files/hair_file.h"
#include "capture/scene_list.h"
#include "capture/scenery/light_volume.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenes/hair_draw.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ropsim {
namespace {

constexpr float kSide = 2.0f;               // longest side of the hair in the scene, decimetres
constexpr float kLeastHalfWidth = 0.0014f;  // about half a pixel of 720 rows: thinner ribbons would have gaps
constexpr std::size_t kPointsADraw = std::size_t{1} << 22;  // 128 MiB of 32 bytes: llvmpipe's limit a buffer
constexpr double kMostPoints = 64e6;
constexpr float kShadowStrength = 0.5f;

// Where the file's hair stands in the scene: +z, up in these files, becomes +y; -y looks at the viewer.
struct Placement {
    glm::vec3 centre{0.0f};
    float scale = 1;

    glm::vec3 operator()(glm::vec3 p) const {
        const glm::vec3 q = scale * (p - centre);
        return {q.x, q.z, -q.y};
    }
};

Placement place_hair(const HairFile& hair, const std::string& path) {
    glm::vec3 low(std::numeric_limits<float>::infinity());
    glm::vec3 high = -low;
    for (const glm::vec3& p : hair.points) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const glm::vec3 size = high - low;
    const float longest = std::max({size.x, size.y, size.z});
    if (!(longest > 1e-12f)) throw UserError(path, "all strands lie in one point; nothing can be drawn");
    return {0.5f * (low + high), kSide / longest};
}

class HairFileScene final : public SceneSource {
 public:
    HairFileScene(const std::string& path, double aspect, std::uint64_t seed)
        : path_(path), aspect_(aspect), seed_(seed), hair_(load_hair(path)), place_(place_hair(hair_, path)) {
        thin_ = std::all_of(hair_.thickness.begin(), hair_.thickness.end(), [](float t) { return t == 0; });
        for (std::size_t i = 0; i < hair_.strands(); ++i)
            if (visible(i)) strands_.push_back(i);
        if (strands_.empty())
            throw UserError(path, "all strands are fully transparent; nothing can be drawn");
    }

    Scene build(const SceneScale& scale) const override {
        const std::vector<Copy> copies = choose(scale.count);
        Scene scene;
        scene.description = fmt::format("{}, {} strands", path_, copies.size());
        scene.camera = look_at({0.9f, 0.35f, 4.9f}, {0, 0, 0}, 26, aspect_, 1.0, 1.0f, 10);
        scene.camera.metres_per_unit = 0.1f;
        scene.light = light_camera(light_direction(), glm::vec3(0), 0.9f * kSide);
        scene.background = {0.32f, 0.36f, 0.4f};
        LightVolume volume(glm::vec3(-0.52f * kSide), glm::vec3(0.52f * kSide));
        const float share = static_cast<float>(std::min(1.0, 1.0 / scale.count));
        for (const Copy& copy : copies) deposit(copy, share, volume);
        volume.illuminate(light_direction());
        for (std::size_t first = 0; first < copies.size();) {
            std::size_t points = 0;
            std::size_t last = first;
            while (last < copies.size() && points + strand_points(copies[last]) <= kPointsADraw)
                points += strand_points(copies[last++]);
            scene.transparent.push_back(draw_strands({copies.begin() + static_cast<std::ptrdiff_t>(first),
                                                      copies.begin() + static_cast<std::ptrdiff_t>(last)},
                                                     volume));
            first = last;
        }
        return scene;
    }

 private:
    // A strand of the file, drawn `shift` beside its place.
    struct Copy {
        std::size_t strand;
        glm::vec3 shift;
    };

    std::size_t strand_points(const Copy& copy) const {
        return hair_.first_points[copy.strand + 1] - hair_.first_points[copy.strand];
    }

    // A segment has the look of its farther point.
    bool visible(std::size_t strand) const {
        for (std::size_t i = hair_.first_points[strand] + 1; i < hair_.first_points[strand + 1]; ++i)
            if (ribbon(i).y > 0) return true;
        return false;
    }

    // Every strand `count` times on average: below 1 a random choice, above with copies close by.
    std::vector<Copy> choose(double count) const {
        if (count * static_cast<double>(hair_.points.size()) > kMostPoints)
            throw UserError(
                "--fragments",
                fmt::format("the hair would need {:.0f} million points, more than {:.0f}; ask "
                            "for fewer fragments or use a larger --size",
                            count * static_cast<double>(hair_.points.size()) / 1e6, kMostPoints / 1e6));
        std::vector<Copy> copies;
        const double whole = std::floor(count);
        for (std::size_t i : strands_) {
            const std::uint64_t key = mix64(seed_ * 0x9E3779B97F4A7C15ull + i);
            const int times = static_cast<int>(whole) + (random_unit(key, 0) < count - whole);
            for (int k = 0; k < times; ++k) {
                const auto unit = [&](std::uint32_t draw) {
                    return random_unit(key, static_cast<std::uint32_t>(3 * k) + draw) - 0.5f;
                };
                const float distance = k == 0 ? 0.0f : 0.01f * kSide;
                copies.push_back({i, distance * glm::vec3(unit(1), unit(2), unit(3))});
            }
        }
        if (copies.empty()) copies.push_back({strands_[0], glm::vec3(0)});
        return copies;
    }

    // Half width and alpha of a point's ribbon. One thinner than can be seen is drawn that wide and covers in
    // proportion; without any thickness in the file the least width is taken as the strands' own.
    glm::vec2 ribbon(std::size_t point) const {
        const float opacity = 1.0f - hair_.transparency[point];
        const float half_width = 0.5f * place_.scale * hair_.thickness[point];
        if (thin_ || half_width >= kLeastHalfWidth) return {std::max(half_width, kLeastHalfWidth), opacity};
        return {kLeastHalfWidth, opacity * half_width / kLeastHalfWidth};
    }

    void deposit(const Copy& copy, float share, LightVolume& volume) const {
        for (std::size_t i = hair_.first_points[copy.strand]; i + 1 < hair_.first_points[copy.strand + 1];
             ++i) {
            const glm::vec3 a = place_(hair_.points[i]);
            const glm::vec3 b = place_(hair_.points[i + 1]);
            const glm::vec2 look = ribbon(i);
            volume.deposit(0.5f * (a + b) + copy.shift, share * 2 * look.x * look.y * glm::distance(a, b));
        }
    }

    SceneDraw draw_strands(const std::vector<Copy>& copies, const LightVolume& volume) const {
        SceneDraw draw;
        draw.state.name = "strands";
        draw.vertex = shader_source("hair_file_vertex");
        draw.shading = shader_source("hair_shading");
        SceneBuffer points{1, {}};
        std::uint32_t next = 0;
        for (const Copy& copy : copies) {
            const std::size_t first = hair_.first_points[copy.strand];
            const std::size_t last = hair_.first_points[copy.strand + 1];
            for (std::size_t i = first; i < last; ++i, ++next) {
                const glm::vec3 p = place_(hair_.points[i]) + copy.shift;
                const glm::vec2 look = ribbon(i);
                const float end = i == first ? 2.0f : i + 1 == last ? 4.0f : 0.0f;
                const glm::vec3 rgb = glm::round(255.0f * hair_.colors[i]);
                points.values.insert(points.values.end(),
                                     {p.x, p.y, p.z, end + volume.transmittance(p, kShadowStrength),
                                      65536 * rgb.r + 256 * rgb.g + rgb.b, look.y, look.x, 0.0f});
                // Fully transparent segments are not drawn.
                if (i > first && look.y > 0) append_ribbon_indices(next - 1, 2, draw.indices);
            }
        }
        draw.primitives = static_cast<std::uint32_t>(draw.indices.size() / 3);
        draw.buffers = {std::move(points)};
        draw.parameters = {glm::vec4(light_direction(), 0)};
        return draw;
    }

    std::string path_;
    double aspect_;
    std::uint64_t seed_;
    HairFile hair_;
    Placement place_;
    bool thin_ = false;                 // no point has a thickness
    std::vector<std::size_t> strands_;  // of which something can be seen
};

}  // namespace

std::unique_ptr<SceneSource> make_hair_file_scene(const std::string& path, double aspect,
                                                  std::uint64_t seed) {
    return std::make_unique<HairFileScene>(path, aspect, seed);
}

}  // namespace ropsim
