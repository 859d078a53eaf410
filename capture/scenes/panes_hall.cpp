// The hall: opaque.
#include "capture/scenes/panes_hall.h"

#include "base/random.h"
#include "capture/geometry/chess_pieces.h"
#include "capture/geometry/implicit_mesh.h"
#include "capture/scenery/scene_parts.h"
#include "capture/shader_sources.h"

#include <cmath>
#include <string>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

// Patterns of hall_shading.glsl.
constexpr float kPlain = 0;
constexpr float kFloor = 1;
constexpr float kChequers = 2;
constexpr float kBands = 3;
constexpr float kBoards = 4;

constexpr float kWallZ = -4.6f;
constexpr float kPieceScale = 12.2f;  // a knight is 85 cm tall
constexpr glm::vec3 kTeal(0.03f, 0.24f, 0.27f);
constexpr glm::vec3 kVermilion(0.6f, 0.09f, 0.035f);

// Local: feet on y = 0, looks along +z, the palm 40 cm before the chest.
constexpr glm::vec3 kFigure(2.2f, 0.0f, -0.424f);

struct Piece {
    ChessPiece kind;
    glm::vec2 place;
    float yaw;
    glm::vec3 color;
};

// Behind the panes a row of knights, all alike and alike far, then others farther and farther away.
std::vector<Piece> pieces() {
    std::vector<Piece> all;
    for (int i = 0; i < 6; ++i)
        all.push_back({ChessPiece::kKnight,
                       {0.735f * static_cast<float>(i) - 2.205f, -0.6f},
                       0.3f,
                       i % 2 == 0 ? kVermilion : kTeal});
    all.push_back({ChessPiece::kKing, {-1.84f, -2.6f}, 0.3f, kTeal});
    all.push_back({ChessPiece::kBishop, {-1.05f, -1.7f}, 0, kVermilion});
    all.push_back({ChessPiece::kQueen, {-0.35f, -3.2f}, 0, kVermilion});
    all.push_back({ChessPiece::kRook, {0.42f, -1.9f}, 0, kTeal});
    all.push_back({ChessPiece::kKing, {1.15f, -2.7f}, 0.3f, kVermilion});
    all.push_back({ChessPiece::kPawn, {2.65f, -1.6f}, 0, kTeal});
    return all;
}

MeshInstance box(glm::vec3 low, glm::vec3 high, glm::vec3 color, float pattern = kPlain) {
    return {placed(0.5f * (low + high), 0.5f * (high - low)), glm::vec4(color, pattern)};
}

// A case of books along the far wall: detail that diffusion dissolves.
void add_books(std::vector<MeshInstance>& boxes) {
    const glm::vec3 wood(0.23f, 0.12f, 0.055f);
    constexpr float kHalfWidth = 3.9f;
    constexpr int kShelves = 7;
    constexpr float kShelf = 0.42f;
    for (int shelf = 0; shelf <= kShelves; ++shelf) {
        const float y = 0.08f + kShelf * static_cast<float>(shelf);
        boxes.push_back(
            box({-kHalfWidth, y, kWallZ}, {kHalfWidth, y + 0.035f, kWallZ + 0.34f}, wood, kBoards));
        if (shelf == kShelves) break;
        float x = -kHalfWidth + 0.04f;
        for (std::uint64_t book = 0; x < kHalfWidth - 0.1f; ++book) {
            const std::uint64_t key = mix64(0x50616E65ull + 1000 * static_cast<std::uint64_t>(shelf) + book);
            const float thick = 0.035f + 0.06f * random_unit(key, 0);
            const float tall = 0.22f + 0.13f * random_unit(key, 1);
            const float hue = random_unit(key, 2);
            const glm::vec3 dye(0.5f + 0.5f * std::cos(6.28f * hue),
                                0.5f + 0.5f * std::cos(6.28f * (hue - 0.31f)),
                                0.45f + 0.45f * std::cos(6.28f * (hue - 0.6f)));
            const glm::vec3 cover =
                (0.1f + 0.45f * random_unit(key, 3)) * glm::mix(dye, glm::vec3(0.62f, 0.5f, 0.38f), 0.45f);
            if (random_unit(key, 4) > 0.1f)
                boxes.push_back(
                    box({x, y + 0.035f, kWallZ + 0.02f},
                        {x + thick, y + 0.035f + tall, kWallZ + 0.2f + 0.1f * random_unit(key, 5)}, cover));
            x += thick + 0.003f;
        }
    }
    constexpr int kUprights = 7;
    for (int upright = 0; upright < kUprights; ++upright) {
        const float at = kHalfWidth * (2.0f * static_cast<float>(upright) / (kUprights - 1) - 1);
        boxes.push_back(box({at - 0.02f, 0, kWallZ}, {at + 0.02f, 0.12f + kShelf * kShelves, kWallZ + 0.36f},
                            wood, kBoards));
    }
}

std::vector<MeshInstance> room(const std::vector<glm::vec4>& stands) {
    std::vector<MeshInstance> boxes = {
        box({-7, -0.04f, -5}, {7, 0, 8}, {0.05f, 0.075f, 0.06f}, kFloor),
        box({-7, 0, kWallZ - 0.1f}, {7, 4.2f, kWallZ}, {0.27f, 0.36f, 0.36f}),
        box({-7, 0, kWallZ}, {7, 0.08f, kWallZ + 0.03f}, {0.3f, 0.28f, 0.25f}),
        // Pressed against the frosted side of its pane.
        box({1.155f, 0, -0.35f}, {1.495f, 0.34f, -0.0068f}, {0.02f, 0.02f, 0.025f}, kChequers)};
    for (const glm::vec4& stand : stands)
        boxes.push_back({placed({stand.x, 0.02f, stand.z}, {0.1f, 0.02f, 0.055f}, stand.w),
                         {0.05f, 0.05f, 0.055f, kPlain}});
    add_books(boxes);
    return boxes;
}

struct Dressed {
    const char* name;
    BlobBody body;
    glm::vec4 color;
};

// A lay figure; one hand is flat on the glass, the rest of it stands further and further back.
std::vector<Dressed> figure() {
    const glm::vec3 wrist(-0.235f, 1.4f, 0.345f);
    const glm::vec3 palm(-0.235f, 1.475f, 0.388f);
    std::vector<Blob> hands = {ellipsoid(palm, {0.047f, 0.055f, 0.018f}, 0.01f),
                               limb(wrist, palm - glm::vec3(0, 0.03f, 0), 0.029f, 0.03f, 0.03f)};
    for (int finger = 0; finger < 4; ++finger) {
        const float across = static_cast<float>(finger) - 1.5f;
        const float length = finger == 1 || finger == 2 ? 0.094f : 0.078f;
        const glm::vec3 root = palm + glm::vec3(0.0235f * across, 0.042f, 0.002f);
        hands.push_back(
            limb(root, root + glm::vec3(0.014f * across, length, 0.0f), 0.0115f, 0.0095f, 0.006f));
    }
    hands.push_back(limb(palm + glm::vec3(0.03f, -0.015f, 0.0f), palm + glm::vec3(0.088f, 0.04f, 0.002f),
                         0.0145f, 0.0105f, 0.01f));
    hands.push_back(limb({0.3f, 0.86f, 0.05f}, {0.31f, 0.72f, 0.09f}, 0.035f, 0.028f, 0.02f));
    hands.push_back(ellipsoid({0.0f, 1.68f, 0.02f}, {0.085f, 0.12f, 0.1f}, 0.02f));
    hands.push_back(limb({0.0f, 1.5f, 0.0f}, {0.0f, 1.62f, 0.01f}, 0.05f, 0.048f, 0.03f));
    hands.push_back(ellipsoid({0.0f, 1.67f, 0.118f}, {0.014f, 0.025f, 0.02f}, 0.02f));
    const std::vector<Blob> shirt = {
        limb({0, 1.36f, 0.0f}, {0, 1.05f, 0.0f}, 0.155f, 0.13f, 0.1f),
        ellipsoid({0, 1.36f, 0.01f}, {0.2f, 0.13f, 0.12f}, 0.1f),
        limb({-0.19f, 1.41f, 0}, {-0.29f, 1.2f, 0.14f}, 0.06f, 0.046f, 0.05f),
        limb({-0.29f, 1.2f, 0.14f}, wrist, 0.045f, 0.037f, 0.02f),
        limb({0.19f, 1.41f, 0}, {0.28f, 1.14f, -0.02f}, 0.06f, 0.048f, 0.05f),
        limb({0.28f, 1.14f, -0.02f}, {0.3f, 0.88f, 0.05f}, 0.046f, 0.038f, 0.02f)};
    const std::vector<Blob> trousers = {
        ellipsoid({0, 0.96f, 0}, {0.16f, 0.12f, 0.12f}, 0.08f),
        limb({-0.09f, 0.92f, 0}, {-0.12f, 0.5f, 0.02f}, 0.095f, 0.068f, 0.05f),
        limb({-0.12f, 0.5f, 0.02f}, {-0.13f, 0.09f, -0.02f}, 0.067f, 0.05f, 0.03f),
        limb({0.09f, 0.92f, 0}, {0.12f, 0.5f, 0.04f}, 0.095f, 0.068f, 0.05f),
        limb({0.12f, 0.5f, 0.04f}, {0.13f, 0.09f, 0.0f}, 0.067f, 0.05f, 0.03f),
        ellipsoid({-0.13f, 0.045f, 0.05f}, {0.05f, 0.045f, 0.12f}, 0.04f),
        ellipsoid({0.13f, 0.045f, 0.07f}, {0.05f, 0.045f, 0.12f}, 0.04f)};
    return {{"head and hands", BlobBody(hands), {0.62f, 0.36f, 0.2f, kPlain}},
            {"shirt", BlobBody(shirt), {0.03f, 0.06f, 0.2f, kBands}},
            {"trousers", BlobBody(trousers), {0.06f, 0.055f, 0.07f, kPlain}}};
}

void add_shadows(TableLight& light, const std::vector<Piece>& all) {
    for (const Piece& piece : all)
        light.shadow(
            {piece.place, 0.1f * kPieceScale,
             [&](float height) { return kPieceScale * chess_piece_radius(piece.kind, height / kPieceScale); },
             glm::vec3(0.0f)});
    light.shadow({{kFigure.x, kFigure.z},
                  1.8f,
                  [](float height) { return height > 1.55f  ? 0.1f
                                            : height > 0.9f ? 0.2f
                                                            : 0.17f; },
                  glm::vec3(0.0f)});
    light.shadow({{1.325f, -0.18f}, 0.34f, [](float) { return 0.2f; }, glm::vec3(0.0f)});
}

}  // namespace

glm::vec3 hall_sun() {
    return glm::normalize(glm::vec3(-0.42f, 0.85f, -0.5f));
}

std::vector<SceneDraw> hall_draws(const std::vector<glm::vec4>& stands, TableLight light) {
    const std::vector<Piece> all = pieces();
    add_shadows(light, all);
    std::vector<SceneDraw> draws;
    const auto add = [&](const std::string& name, const TriangleMesh& mesh,
                         const std::vector<MeshInstance>& copies) {
        SceneDraw draw = matte_draw(name, mesh, copies);
        draw.shading =
            std::string(shader_source("hall_environment")) + std::string(shader_source("hall_shading"));
        draw.parameters = {glm::vec4(hall_sun(), 0), light.rectangle()};
        draw.textures.push_back(light.texture());
        draws.push_back(std::move(draw));
    };
    add("hall", box_mesh(), room(stands));
    for (int kind = 0; kind < kChessPieces; ++kind) {
        std::vector<MeshInstance> copies;
        for (const Piece& piece : all)
            if (static_cast<int>(piece.kind) == kind)
                copies.push_back(
                    {placed({piece.place.x, 0, piece.place.y}, glm::vec3(kPieceScale), piece.yaw),
                     glm::vec4(piece.color, kBands)});
        add("pieces", chess_piece_mesh(static_cast<ChessPiece>(kind)), copies);
    }
    for (const Dressed& part : figure())
        add(part.name, part.body.mesh({-0.5f, -0.03f, -0.25f}, {0.5f, 1.85f, 0.45f}, 0.0085f),
            {{placed(kFigure, glm::vec3(1.0f)), part.color}});
    return draws;
}

}  // namespace ropsim
