// Chess pieces after Staunton's pattern, as closed meshes.
#pragma once

#include "capture/geometry/mesh.h"

#include <glm/glm.hpp>

namespace ropsim {

enum class ChessPiece { kPawn, kRook, kKnight, kBishop, kQueen, kKing };
inline constexpr int kChessPieces = 6;

// Side of a square of the board that the pieces are made for, metres.
inline constexpr float kChessSquare = 0.055f;

// Metres, the foot on y = 0 about the y axis; the knight looks along +x.
TriangleMesh chess_piece_mesh(ChessPiece piece);

// The piece's outline as a surface of revolution: its radius at `height` metres, 0 above it.
float chess_piece_radius(ChessPiece piece, float height);

}  // namespace ropsim
