// Scene: a chess game of red and clear glass on a table by a window, and crossed bars of coloured glass
// behind it (McGuire and Mara 2017, Figs. 7, 18 and 19).
//
// Materials as the paper means them (section 4.1): coverage 1, transmission per channel at normal incidence
// raised by the way through the wall and lowered by what Fresnel's law reflects, index 1.5, collimation 1;
// colour is reflected light only, white as the paper says of its bars, and a little of what inner reflections
// bring. The trace's alpha is the least that says the same (transmissive() in capture/shaders/surface.glsl).
#include "base/error.h"
#include "base/random.h"
#include "capture/geometry/chess_pieces.h"
#include "capture/scene_list.h"
#include "capture/scenery/table_light.h"
#include "capture/scenery/transmissive_draw.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

// An Italian game after both sides have castled; lower case is red.
constexpr std::string_view kPosition = "r1bq1rk1/ppp2ppp/2np1n2/2b1p3/2B1P3/2NP1N2/PPP2PPP/R1BQ1RK1";
constexpr std::string_view kLetters = "prnbqk";  // in the order of ChessPiece
constexpr double kMaxSets = 50'000;

constexpr glm::vec3 kClear(0.8f, 0.87f, 0.84f);
constexpr glm::vec3 kRed(0.84f, 0.2f, 0.15f);
constexpr float kFelt = 0.0008f;  // under the pieces, metres
constexpr glm::vec3 kToWindow(-2.2f, 1.15f, -1.15f);

// Where the bars stand, and what they are made of.
constexpr float kBarsZ = -0.3f;
constexpr float kBarHalfLength = 0.15f;
constexpr float kBarHalfWidth = 0.019f;
constexpr float kBarHalfDepth = 0.006f;
constexpr float kBarPitch = 0.053f;
constexpr float kBarsMiddle = 0.138f;  // height
constexpr glm::vec3 kBarColors[] = {{0.93f, 0.3f, 0.26f},
                                    {0.95f, 0.84f, 0.3f},
                                    {0.36f, 0.87f, 0.42f},
                                    {0.36f, 0.82f, 0.93f},
                                    {0.5f, 0.42f, 0.92f}};

struct Piece {
    ChessPiece kind;
    bool red;
    glm::vec3 place;
    float yaw;
};

std::vector<Piece> game(std::uint64_t seed) {
    std::vector<Piece> pieces;
    int file = 0;
    int rank = 7;
    for (char letter : kPosition) {
        if (letter == '/') {
            file = 0;
            --rank;
            continue;
        }
        if (letter >= '1' && letter <= '8') {
            file += letter - '0';
            continue;
        }
        const bool red = letter >= 'a';
        const auto kind = kLetters.find(red ? letter : static_cast<char>(letter - 'A' + 'a'));
        const std::uint64_t key = mix64(seed ^ 0x43686573ull) + static_cast<std::uint64_t>(64 * rank + file);
        // Nobody sets pieces down exactly in the middle.
        const auto along = [&](int square, std::uint32_t draw) {
            return kChessSquare *
                   (static_cast<float>(square) - 3.5f + 0.14f * (random_unit(key, draw) - 0.5f));
        };
        Piece piece{static_cast<ChessPiece>(kind), red, {along(file, 0), kFelt, -along(rank, 1)}, 0};
        // Knights turned half aside, as many players like them.
        piece.yaw = (red ? -0.9f : 0.2f) * glm::pi<float>() + 0.6f * (random_unit(key, 2) - 0.5f);
        pieces.push_back(piece);
        ++file;
    }
    return pieces;
}

// Beyond the game's own: pieces anywhere on the board.
Piece further_piece(std::uint64_t seed, std::uint32_t index) {
    const std::uint64_t key = mix64(seed * 0x9E3779B97F4A7C15ull + index);
    Piece piece{static_cast<ChessPiece>(random_bits(key, 0) % kChessPieces),
                random_unit(key, 1) < 0.5f,
                {0.42f * (random_unit(key, 2) - 0.5f), kFelt, 0.42f * (random_unit(key, 3) - 0.5f)},
                glm::two_pi<float>() * random_unit(key, 4)};
    return piece;
}

// What arrives of the sun at a point of the table through the bars.
glm::vec3 through_bars(glm::vec2 p, glm::vec3 to_sun) {
    glm::vec3 left(1.0f);
    const float way = (kBarsZ - p.y) / to_sun.z;
    if (way <= 0) return left;
    const glm::vec2 at(p.x + way * to_sun.x, way * to_sun.y - kBarsMiddle);
    for (int axis = 0; axis < 2; ++axis) {
        if (std::abs(at[1 - axis]) > kBarHalfLength) continue;
        for (int i = 0; i < 5; ++i) {
            const float edge = std::abs(at[axis] - kBarPitch * static_cast<float>(i - 2)) / kBarHalfWidth;
            const glm::vec3 color = kBarColors[axis == 0 ? i : 4 - i];
            left *= glm::mix(color * color, glm::vec3(1.0f), glm::smoothstep(0.9f, 1.1f, edge));
        }
    }
    return left;
}

TableLight table_light(const std::vector<Piece>& pieces, glm::vec3 to_sun) {
    TableLight light({-0.4f, -0.45f}, 1.0f, to_sun);
    light.filter([&](glm::vec2 at) { return through_bars(at, to_sun); });
    for (const Piece& piece : pieces) {
        light.shadow({{piece.place.x, piece.place.z},
                      0.1f,
                      [&](float height) { return chess_piece_radius(piece.kind, height); },
                      piece.red ? kRed : kClear});
    }
    return light;
}

MeshInstance box(glm::vec3 low, glm::vec3 high, glm::vec3 color, float pattern = 0) {
    return {placed(0.5f * (low + high), 0.5f * (high - low)), glm::vec4(color, pattern)};
}

class GlassScene final : public SceneSource {
 public:
    GlassScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed) {
        shrinks = true;
        for (int i = 0; i < kChessPieces; ++i)
            meshes_.push_back(chess_piece_mesh(static_cast<ChessPiece>(i)));
    }

    Scene build(const SceneScale& scale) const override {
        if (scale.count > kMaxSets) {
            throw UserError("--fragments",
                            fmt::format("'glass' would need {:.0f} sets, more than {:.0f}; ask "
                                        "for fewer fragments or use a larger --size",
                                        scale.count, kMaxSets));
        }
        std::vector<Piece> pieces = game(seed_);
        const std::size_t own = pieces.size();
        const auto wanted = static_cast<std::size_t>(std::round(static_cast<double>(own) * scale.count));
        for (std::size_t i = own; i < wanted; ++i)
            pieces.push_back(further_piece(seed_, static_cast<std::uint32_t>(i)));
        const glm::mat4 sized = glm::scale(glm::mat4(1.0f), glm::vec3(static_cast<float>(scale.size)));
        Scene scene;
        scene.description = fmt::format("{} chess pieces of glass and 10 crossed glass bars", pieces.size());
        scene.materials = true;
        scene.camera = look_at({0.15f, 0.2f, 0.4f}, {-0.005f, 0.042f, -0.02f}, 35, aspect_, 1.4, 0.1f, 12);
        scene.light = light_camera(glm::normalize(kToWindow), {0, 0.1f, 0}, 0.55f);
        scene.background = {0.1f, 0.09f, 0.08f};
        scene.opaque.push_back(
            room(std::vector<Piece>(pieces.begin(), pieces.begin() + static_cast<long>(own))));
        for (int kind = kChessPieces - 1; kind >= 0; --kind) {
            std::vector<MeshInstance> copies;
            for (const Piece& piece : pieces) {
                if (static_cast<int>(piece.kind) != kind) continue;
                copies.push_back({sized * placed(piece.place, glm::vec3(1.0f), piece.yaw),
                                  glm::vec4(piece.red ? kRed : kClear, 1.0f)});
            }
            static constexpr const char* kNames[] = {"pawns",   "rooks",  "knights",
                                                     "bishops", "queens", "kings"};
            scene.transparent.push_back(
                transmissive_draw(kNames[kind], meshes_[static_cast<std::size_t>(kind)], copies, look()));
        }
        scene.transparent.push_back(transmissive_draw("bars", box_mesh(), bars(sized), look()));
        return scene;
    }

 private:
    static GlassLook look() {
        GlassLook look;
        look.environment = "room_environment";
        look.to_sun = glm::normalize(kToWindow);
        look.sun = glm::vec3(140, 120, 90);
        look.inner_reflections = 0.2f;
        look.reflectance = 0.05f;
        return look;
    }

    // One layer upright, one lying, 2 cm apart.
    static std::vector<MeshInstance> bars(const glm::mat4& sized) {
        std::vector<MeshInstance> all;
        for (int i = 0; i < 5; ++i) {
            const float side = kBarPitch * static_cast<float>(i - 2);
            all.push_back(
                {sized * placed({side, kBarsMiddle, kBarsZ}, {kBarHalfWidth, kBarHalfLength, kBarHalfDepth}),
                 glm::vec4(kBarColors[i], 1)});
            all.push_back({sized * placed({0, kBarsMiddle + side, kBarsZ + 0.02f},
                                          {kBarHalfLength, kBarHalfWidth, kBarHalfDepth}),
                           glm::vec4(kBarColors[4 - i], 1)});
        }
        return all;
    }

    static SceneDraw room(const std::vector<Piece>& pieces) {
        const glm::vec3 plaster(0.62f, 0.55f, 0.45f);
        const glm::vec3 wood(0.36f, 0.19f, 0.09f);
        std::vector<MeshInstance> boxes = {
            box({-0.24f, -0.02f, -0.24f}, {0.24f, 0.0f, 0.24f}, wood, 1),
            box({-0.9f, -0.06f, -0.55f}, {0.9f, -0.02f, 0.7f}, wood, 2),
            box({-0.24f, -0.02f, kBarsZ - 0.03f}, {0.24f, -0.005f, kBarsZ + 0.045f}, {0.06f, 0.05f, 0.05f}),
            box({-3, -0.8f, -3}, {3, -0.76f, 3}, {0.3f, 0.17f, 0.09f}, 2),
            box({-3, -0.8f, -3.1f}, {3, 2.6f, -3}, plaster),
            box({-3, -0.8f, -3.0f}, {3, -0.1f, -2.97f}, {0.36f, 0.38f, 0.33f}),
            box({-3, -0.1f, -3.0f}, {3, -0.04f, -2.94f}, {0.7f, 0.68f, 0.62f})};
        add_furniture(boxes);
        SceneDraw draw = matte_draw("room", box_mesh(), boxes);
        draw.shading = shader_source("room_shading");
        const glm::vec3 to_sun = glm::normalize(kToWindow);
        const TableLight light = table_light(pieces, to_sun);
        draw.parameters = {glm::vec4(to_sun, 0), light.rectangle()};
        draw.textures.push_back(light.texture());
        return draw;
    }

    // A bookcase, a picture and a sofa against the far wall.
    static void add_furniture(std::vector<MeshInstance>& boxes) {
        const glm::vec3 wood(0.3f, 0.16f, 0.08f);
        for (int shelf = 0; shelf < 5; ++shelf) {
            const float y = -0.76f + 0.36f * static_cast<float>(shelf);
            boxes.push_back(box({0.55f, y, -2.95f}, {2.2f, y + 0.03f, -2.62f}, wood));
            float x = 0.6f;
            for (std::uint32_t book = 0; x < 2.12f && shelf < 4; ++book) {
                const std::uint64_t key =
                    mix64(0x426F6F6Bull + 100 * static_cast<std::uint64_t>(shelf) + book);
                const float thick = 0.025f + 0.035f * random_unit(key, 0);
                const float tall = 0.2f + 0.1f * random_unit(key, 1);
                const glm::vec3 cover(0.08f + 0.45f * random_unit(key, 2),
                                      0.06f + 0.25f * random_unit(key, 3),
                                      0.05f + 0.3f * random_unit(key, 4));
                if (random_unit(key, 5) > 0.12f)
                    boxes.push_back(box({x, y + 0.03f, -2.9f}, {x + thick, y + 0.03f + tall, -2.68f}, cover));
                x += thick + 0.002f;
            }
        }
        for (float x : {0.52f, 2.2f})
            boxes.push_back(box({x, -0.76f, -2.95f}, {x + 0.03f, 0.73f, -2.6f}, wood));
        boxes.push_back(box({-1.1f, 0.25f, -2.99f}, {-0.1f, 0.95f, -2.95f}, {0.1f, 0.07f, 0.05f}));
        boxes.push_back(box({-1.04f, 0.31f, -2.96f}, {-0.16f, 0.89f, -2.94f}, {0.25f, 0.38f, 0.46f}));
        boxes.push_back(box({-1.04f, 0.31f, -2.945f}, {-0.16f, 0.5f, -2.935f}, {0.2f, 0.3f, 0.12f}));
        for (float x : {-0.16f, 0.152f})
            boxes.push_back(box({x, -0.02f, kBarsZ - 0.012f}, {x + 0.008f, 0.29f, kBarsZ + 0.032f},
                                {0.05f, 0.04f, 0.035f}));
        const glm::vec3 cloth(0.4f, 0.37f, 0.3f);
        boxes.push_back(box({-1.9f, -0.76f, -2.8f}, {0.1f, -0.32f, -1.95f}, cloth));
        boxes.push_back(box({-1.9f, -0.4f, -2.9f}, {0.1f, 0.08f, -2.6f}, 1.15f * cloth));
        for (float x : {-2.0f, -0.1f})
            boxes.push_back(box({x, -0.76f, -2.85f}, {x + 0.2f, -0.12f, -1.9f}, cloth));
    }

    double aspect_;
    std::uint64_t seed_;
    std::vector<TriangleMesh> meshes_;  // by ChessPiece
};

}  // namespace

std::unique_ptr<SceneSource> make_glass_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<GlassScene>(aspect, seed);
}

}  // namespace ropsim
