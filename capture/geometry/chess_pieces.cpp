// Profiles of the pieces, in centimetres, and what is not turned: the knight's head, crenels, crown and
// cross.
#include "capture/geometry/chess_pieces.h"

#include "capture/geometry/lathe_mesh.h"
#include "capture/geometry/profile.h"
#include "capture/geometry/swept_mesh.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr int kSectors = 40;
constexpr int kSteps = 4;  // of the curves between the profiles' points

using Profile = std::vector<glm::vec2>;

// A foot of radius `base` up to the neck at (`neck`, `top`), then `head`, whose last point is on the axis.
Profile standing(float base, float neck, float top, const Profile& head) {
    Profile curve{{0, 0}, {base, 0}};
    const auto add_curve = [&](const Profile& points) {
        Profile smooth = smooth_profile(points, kSteps);
        // Pieces of the profile meet in corners.
        if (glm::distance(smooth.front(), curve.back()) < 1e-4f) smooth.erase(smooth.begin());
        curve.insert(curve.end(), smooth.begin(), smooth.end());
    };
    add_curve({{base, 0.0f}, {1.02f * base, 0.25f}, {0.9f * base, 0.55f}});
    add_curve({{0.84f * base, 0.62f}, {0.86f * base, 0.8f}, {0.7f * base, 1.08f}});
    const float rise = top - 1.15f;
    add_curve({{0.6f * base, 1.15f},
               {glm::mix(neck, 0.6f * base, 0.36f), 1.15f + 0.25f * rise},
               {glm::mix(neck, 0.6f * base, 0.06f), 1.15f + 0.65f * rise},
               {neck, top}});
    // The collar, then the head.
    const float wide = 1.5f * neck;
    add_curve({{wide, top + 0.05f}, {1.06f * wide, top + 0.16f}, {wide, top + 0.27f}});
    add_curve(head);
    return curve;
}

Profile profile_of(ChessPiece piece) {
    switch (piece) {
        case ChessPiece::kPawn:
            return standing(
                1.45f, 0.56f, 3.2f,
                {{0.6f, 3.5f}, {0.92f, 3.85f}, {1.06f, 4.4f}, {0.92f, 4.95f}, {0.5f, 5.33f}, {0.0f, 5.45f}});
        case ChessPiece::kRook: {
            Profile rook =
                standing(1.7f, 0.92f, 3.9f, {{1.0f, 4.2f}, {1.08f, 4.5f}, {1.36f, 4.85f}, {1.4f, 5.1f}});
            rook.insert(rook.end(), {{1.4f, 5.35f}, {0.98f, 5.35f}, {0.98f, 5.1f}, {0.0f, 5.1f}});
            return rook;
        }
        case ChessPiece::kKnight:
            return standing(1.7f, 1.25f, 1.75f, {{1.3f, 2.05f}, {1.1f, 2.25f}, {0.0f, 2.4f}});
        case ChessPiece::kBishop:
            return standing(1.65f, 0.62f, 4.55f,
                            {{0.66f, 4.85f},
                             {0.98f, 5.35f},
                             {1.0f, 5.85f},
                             {0.72f, 6.5f},
                             {0.3f, 6.95f},
                             {0.24f, 7.02f},
                             {0.34f, 7.2f},
                             {0.22f, 7.42f},
                             {0.0f, 7.48f}});
        case ChessPiece::kQueen:
            return standing(1.85f, 0.72f, 5.6f,
                            {{0.7f, 5.92f},
                             {0.82f, 6.6f},
                             {1.18f, 7.5f},
                             {1.28f, 7.62f},
                             {1.05f, 7.68f},
                             {0.75f, 7.85f},
                             {0.3f, 8.08f},
                             {0.36f, 8.3f},
                             {0.22f, 8.52f},
                             {0.0f, 8.58f}});
        case ChessPiece::kKing:
            return standing(1.9f, 0.78f, 6.0f,
                            {{0.78f, 6.32f},
                             {0.92f, 7.0f},
                             {1.22f, 7.85f},
                             {1.26f, 7.98f},
                             {1.0f, 8.1f},
                             {0.4f, 8.4f},
                             {0.24f, 8.48f},
                             {0.0f, 8.5f}});
    }
    return {};
}

// A pillow-edged horse's head and neck, looking along +x.
TriangleMesh horse_head() {
    // From the chest up the throat, round the muzzle, over the brow and ear, down the mane.
    const Profile corners = {{1.12f, 2.1f},  {1.02f, 2.75f}, {0.62f, 3.45f},  {0.5f, 4.05f},   {0.88f, 4.2f},
                             {1.28f, 4.0f},  {1.58f, 4.05f}, {1.74f, 4.35f},  {1.62f, 4.75f},  {1.2f, 5.25f},
                             {0.82f, 5.9f},  {0.5f, 6.35f},  {0.3f, 6.95f},   {0.02f, 6.45f},  {-0.45f, 6.2f},
                             {-0.95f, 5.5f}, {-1.2f, 4.6f},  {-1.22f, 3.65f}, {-1.12f, 2.75f}, {-1.1f, 2.1f}};
    const glm::vec2 middle(0.05f, 4.1f);
    Profile smooth;
    // The curve is about the middle, where x may be negative; smooth_profile wants distances.
    for (glm::vec2 p : corners) smooth.push_back(p + glm::vec2(10, 0));
    smooth = smooth_profile(smooth, 3);
    SweptProfile sweep;
    for (const glm::vec2& p : smooth) sweep.outline.push_back(p - glm::vec2(10, 0) - middle);
    constexpr int kSlices = 10;
    constexpr float kHalfWidth = 0.72f;
    for (int i = 0; i <= kSlices; ++i) {
        const float angle = glm::pi<float>() * (0.04f + 0.92f * static_cast<float>(i) / kSlices);
        sweep.path.emplace_back(middle, -kHalfWidth * std::cos(angle));
        sweep.scales.push_back(std::pow(std::sin(angle), 0.45f));
    }
    sweep.crease_degrees = 50;
    return swept_mesh(sweep);
}

TriangleMesh merlons() {
    TriangleMesh all;
    constexpr int kCount = 5;
    for (int i = 0; i < kCount; ++i) {
        Profile arc;
        constexpr int kArcSteps = 5;
        for (int side = 0; side < 2; ++side)
            for (int step = 0; step <= kArcSteps; ++step) {
                const int along = side == 0 ? step : kArcSteps - step;
                const float angle = glm::two_pi<float>() *
                                    (static_cast<float>(i) + 0.62f * static_cast<float>(along) / kArcSteps) /
                                    kCount;
                arc.push_back((side == 0 ? 1.39f : 1.0f) * glm::vec2(std::cos(angle), std::sin(angle)));
            }
        // The outline's z axis becomes height.
        append_mesh(all, extruded_mesh(arc, 0.2f),
                    glm::translate(glm::mat4(1.0f), glm::vec3(0, 5.56f, 0)) *
                        glm::rotate(glm::mat4(1.0f), -glm::half_pi<float>(), glm::vec3(1, 0, 0)));
    }
    return all;
}

TriangleMesh cross() {
    const Profile outline = {{-0.14f, 8.45f}, {0.14f, 8.45f},  {0.13f, 8.85f}, {0.42f, 8.8f},
                             {0.42f, 9.16f},  {0.13f, 9.11f},  {0.17f, 9.5f},  {-0.17f, 9.5f},
                             {-0.13f, 9.11f}, {-0.42f, 9.16f}, {-0.42f, 8.8f}, {-0.13f, 8.85f}};
    return extruded_mesh(outline, 0.13f);
}

TriangleMesh coronet() {
    TriangleMesh all;
    constexpr int kPearls = 9;
    const TriangleMesh pearl = sphere_mesh(6);
    for (int i = 0; i < kPearls; ++i) {
        const float angle = glm::two_pi<float>() * static_cast<float>(i) / kPearls;
        const glm::vec3 place(1.17f * std::cos(angle), 7.72f, 1.17f * std::sin(angle));
        append_mesh(all, pearl, glm::scale(glm::translate(glm::mat4(1.0f), place), glm::vec3(0.17f)));
    }
    return all;
}

}  // namespace

TriangleMesh chess_piece_mesh(ChessPiece piece) {
    const glm::mat4 to_metres = glm::scale(glm::mat4(1.0f), glm::vec3(0.01f));
    TriangleMesh mesh;
    append_mesh(mesh, lathe_mesh(profile_of(piece), kSectors), to_metres);
    if (piece == ChessPiece::kKnight) append_mesh(mesh, horse_head(), to_metres);
    if (piece == ChessPiece::kRook) append_mesh(mesh, merlons(), to_metres);
    if (piece == ChessPiece::kKing) append_mesh(mesh, cross(), to_metres);
    if (piece == ChessPiece::kQueen) append_mesh(mesh, coronet(), to_metres);
    return mesh;
}

float chess_piece_radius(ChessPiece piece, float height) {
    const float y = 100 * height;
    if (piece == ChessPiece::kKnight && y > 2 && y < 6.7f) return 0.011f;
    const Profile profile = profile_of(piece);
    float radius = 0;
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
        const glm::vec2 a = profile[i];
        const glm::vec2 b = profile[i + 1];
        if (y < std::min(a.y, b.y) || y > std::max(a.y, b.y) || a.y == b.y) continue;
        radius = std::max(radius, glm::mix(a.x, b.x, (y - a.y) / (b.y - a.y)));
    }
    return 0.01f * radius;
}

}  // namespace ropsim
