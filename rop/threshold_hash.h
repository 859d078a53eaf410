// Thresholds of an alpha test that are hashed from positions in the world: Wyman and McGuire 2017, "Hashed
// Alpha Testing", section 3.
#pragma once

#include "rop/datapath.h"
#include "traces/trace.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace ropsim {

// A position and how many cubes of a pixel's size there are to a unit of length.
struct CubePlace {
    std::array<float, 3> position{};
    float scale = 1;  // positive and finite
};

// World positions of fragments, and a pixel's size there, through a trace's camera.
class PixelCubes {
 public:
    PixelCubes(int width, int height, const Camera& camera) {
        // Window coordinates, y down, to clip space.
        const glm::dmat4 clip{{2.0 / width, 0, 0, 0}, {0, -2.0 / height, 0, 0}, {0, 0, 2, 0}, {-1, 1, -1, 1}};
        const glm::dmat4 project = glm::dmat4(camera.projection) * glm::dmat4(camera.view);
        valid_ = std::isfinite(glm::determinant(project)) && glm::determinant(project) != 0;
        if (valid_) to_world_ = glm::inverse(project) * clip;
    }
    // False where the camera's matrices have no inverse; then there is no position.
    bool valid() const { return valid_; }

    // Of the centre of pixel (x, y) at window depth z.
    CubePlace at(int x, int y, float z) const {
        const glm::dvec3 here = world(x + 0.5, y + 0.5, static_cast<double>(z));
        const double across = glm::length(world(x + 1.5, y + 0.5, static_cast<double>(z)) - here);
        const double down = glm::length(world(x + 0.5, y + 1.5, static_cast<double>(z)) - here);
        const double size = std::max(across, down);
        CubePlace place;
        // A point at infinity has no place: all of them share one cube.
        if (!std::isfinite(here.x + here.y + here.z) || !(size > 1e-30) || !(size < 1e30)) return place;
        for (int i = 0; i < 3; ++i) place.position[static_cast<std::size_t>(i)] = static_cast<float>(here[i]);
        place.scale = static_cast<float>(1.0 / size);
        return place;
    }

 private:
    glm::dvec3 world(double x, double y, double z) const {
        const glm::dvec4 at = to_world_ * glm::dvec4(x, y, z, 1);
        return glm::dvec3(at) / at.w;
    }
    glm::dmat4 to_world_{1.0};
    bool valid_ = false;
};

// 32 bits from three words, each of which may change all of them.
template <class D>
typename D::Uint hash_words(const std::array<typename D::Uint, 3>& words, std::uint32_t seed) {
    using Uint = typename D::Uint;
    // Odd factors, so that no bit of a word is lost; then the finaliser "lowbias32" of Wellons 2018.
    Uint h = words[0] * Uint(0x9E3779B1u) + words[1] * Uint(0x85EBCA77u) + words[2] * Uint(0xC2B2AE3Du);
    h = h + Uint(seed);
    h = (h ^ shifted_right(h, 16)) * Uint(0x7FEB352Du);
    h = (h ^ shifted_right(h, 15)) * Uint(0x846CA68Bu);
    return h ^ shifted_right(h, 16);
}

// The upper 24 bits as a multiple of 2^-24 in (0, 1].
template <class D>
typename D::Real hashed_unit(const typename D::Uint& hash) {
    const typename D::Uint number = shifted_right(hash, 8) + typename D::Uint(1u);
    const float value = static_cast<float>(value_of(number)) * 0x1p-24f;
    if constexpr (D::kCharged)
        return {value, Ledger::active().charge(Unit::kConverter, number.ready)};
    else
        return value;
}

// The number of the cell that a coordinate lies in, where cells are 2^-exponent wide; wraps beyond 2^31.
// Charged: one adder to the exponent and one rounding.
template <class D>
typename D::Uint cell_of(float coordinate, const typename D::Uint& exponent) {
    const auto power = static_cast<std::int32_t>(value_of(exponent));
    const double cell = std::floor(std::ldexp(static_cast<double>(coordinate), power));
    // fmod is exact, and keeps what the conversion can hold.
    const auto number =
        static_cast<std::uint32_t>(static_cast<std::int64_t>(std::fmod(cell, 0x1p32)) & 0xFFFFFFFF);
    if constexpr (D::kCharged) {
        const int scaled = Ledger::active().charge(Unit::kIntegerAdder, exponent.ready);
        return {number, Ledger::active().charge(Unit::kIntegerAdder, scaled)};
    } else {
        return number;
    }
}

// Distribution function at x of (1 - t) u + t v, for u and v uniform in [0, 1] and independent: three pieces,
// two parabolas and the line between them. Makes the blend uniform in (0, 1]. t and x in [0, 1].
template <class D>
typename D::Real blend_distribution(const typename D::Real& x, const typename D::Real& t) {
    using Real = typename D::Real;
    const Real one(1.0f);
    // The parabolas shrink to nothing at t = 0; the floor keeps their division away from 0 / 0.
    const Real a = maximum(minimum(t, one - t), Real(0x1p-24f));
    const Real b = one - a;
    const Real slope = one / b;
    const Real half_curvature = slope / (a + a);
    const Real rest = one - x;
    const Real low = x * x * half_curvature;
    const Real middle = (x - Real(0.5f) * a) * slope;
    const Real high = one - rest * rest * half_curvature;
    return maximum(select(x < b, select(x < a, low, middle), high), Real(0x1p-24f));
}

// The threshold at a place, in (0, 1].
template <class D>
typename D::Real cube_threshold(const CubePlace& place, std::uint32_t seed) {
    using Real = typename D::Real;
    using Uint = typename D::Uint;
    // Exponent and mantissa of the scale are two fields of one word: 2^coarse <= scale < 2^(coarse + 1).
    int exponent = 0;
    const float mantissa = std::frexp(place.scale, &exponent);
    const Uint coarse(static_cast<std::uint32_t>(exponent - 1));
    const Uint fine = coarse + Uint(1u);
    const Real t(2.0f * mantissa - 1.0f);
    const auto unit_at = [&](const Uint& power) {
        // Cells of different sizes must not share their hashes where their numbers are equal.
        std::array<Uint, 3> cell;
        for (std::size_t i = 0; i < 3; ++i) cell[i] = cell_of<D>(place.position[i], power);
        cell[0] = cell[0] ^ (power * Uint(0x27D4EB2Fu));
        return hashed_unit<D>(hash_words<D>(cell, seed));
    };
    const Real u = unit_at(coarse);
    const Real v = unit_at(fine);
    return blend_distribution<D>(u + t * (v - u), t);
}

}  // namespace ropsim
