// Insertion into a compressed visibility function, four nodes at a time: what adaptive transparency's plain
// operation does where nodes are float32 and their number is a multiple of four. The same values, bit for
// bit, as node by node.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace ropsim {

struct VectorInsertion {
    bool compressed = false;  // N + 1 nodes were real ones: one was removed
    int first_changed = 0;    // nodes in front of this one keep their values
};

#if defined(__SSE2__)

// Nodes in groups of four, nearest first.
template <int kQuads>
struct NodeQuads {
    __m128 lane[kQuads];
};

namespace detail {
inline __m128 chosen(__m128 mask, __m128 yes, __m128 no) {
    return _mm_or_ps(_mm_and_ps(mask, yes), _mm_andnot_ps(mask, no));
}
// Every value one place farther; `first` comes in.
template <int kQuads>
inline NodeQuads<kQuads> shifted_back(const NodeQuads<kQuads>& a, __m128 first) {
    NodeQuads<kQuads> out;
    out.lane[0] = _mm_move_ss(_mm_shuffle_ps(a.lane[0], a.lane[0], _MM_SHUFFLE(2, 1, 0, 0)), first);
#pragma GCC unroll 16
    for (int q = 1; q < kQuads; ++q) {
        const __m128 seam = _mm_shuffle_ps(a.lane[q - 1], a.lane[q], _MM_SHUFFLE(0, 0, 3, 3));
        out.lane[q] = _mm_shuffle_ps(seam, a.lane[q], _MM_SHUFFLE(2, 1, 2, 0));
    }
    return out;
}
// Every value one place nearer; `last` (its lowest lane) comes in.
template <int kQuads>
inline NodeQuads<kQuads> shifted_front(const NodeQuads<kQuads>& a, __m128 last) {
    NodeQuads<kQuads> out;
#pragma GCC unroll 16
    for (int q = 0; q < kQuads; ++q) {
        const __m128 next = q + 1 < kQuads ? a.lane[q + 1 < kQuads ? q + 1 : 0] : last;
        const __m128 seam = _mm_shuffle_ps(a.lane[q], next, _MM_SHUFFLE(0, 0, 3, 3));
        out.lane[q] = _mm_shuffle_ps(a.lane[q], seam, _MM_SHUFFLE(2, 0, 2, 1));
    }
    return out;
}
template <int kQuads>
inline NodeQuads<kQuads> loaded(const std::uint32_t* words) {
    NodeQuads<kQuads> out;
#pragma GCC unroll 16
    for (int q = 0; q < kQuads; ++q)
        out.lane[q] = _mm_castsi128_ps(
            _mm_loadu_si128(reinterpret_cast<const __m128i*>(words + std::ptrdiff_t{4} * q)));
    return out;
}
template <int kQuads>
inline void store(const NodeQuads<kQuads>& a, std::uint32_t* words) {
#pragma GCC unroll 16
    for (int q = 0; q < kQuads; ++q)
        _mm_storeu_si128(reinterpret_cast<__m128i*>(words + std::ptrdiff_t{4} * q),
                         _mm_castps_si128(a.lane[q]));
}
// Bit i: sign bit of value i.
template <int kQuads>
inline std::uint32_t sign_bits(const NodeQuads<kQuads>& a) {
    std::uint32_t bits = 0;
#pragma GCC unroll 16
    for (int q = 0; q < kQuads; ++q)
        bits |= static_cast<std::uint32_t>(_mm_movemask_ps(a.lane[q])) << (4 * q);
    return bits;
}
template <int kQuads>
inline NodeQuads<kQuads> less_than(const NodeQuads<kQuads>& a, __m128 b) {
    NodeQuads<kQuads> out;
#pragma GCC unroll 16
    for (int q = 0; q < kQuads; ++q) out.lane[q] = _mm_cmplt_ps(a.lane[q], b);
    return out;
}

// Equation 7: number 1..N of the node whose removal changes the area least, of equal ones the nearest. `z`
// and `v` are nodes 0..N-1, `z_next` and `v_next` nodes 1..N.
template <int kQuads>
inline int least_error_node(const NodeQuads<kQuads>& z, const NodeQuads<kQuads>& v,
                            const NodeQuads<kQuads>& z_next, const NodeQuads<kQuads>& v_next) {
    NodeQuads<kQuads> error;
    __m128 least;
#pragma GCC unroll 16
    for (int q = 0; q < kQuads; ++q) {
        error.lane[q] =
            _mm_mul_ps(_mm_sub_ps(v.lane[q], v_next.lane[q]), _mm_sub_ps(z_next.lane[q], z.lane[q]));
        least = q == 0 ? error.lane[0] : _mm_min_ps(least, error.lane[q]);
    }
    least = _mm_min_ps(least, _mm_shuffle_ps(least, least, _MM_SHUFFLE(1, 0, 3, 2)));
    least = _mm_min_ps(least, _mm_shuffle_ps(least, least, _MM_SHUFFLE(2, 3, 0, 1)));
    NodeQuads<kQuads> is_least;
#pragma GCC unroll 16
    for (int q = 0; q < kQuads; ++q) is_least.lane[q] = _mm_cmpeq_ps(error.lane[q], least);
    return 1 + std::countr_zero(sign_bits(is_least) | (1u << (4 * kQuads - 1)));
}
}  // namespace detail

// Salvi et al. 2011, sections 3.2 and 3.3, removing by underestimation any node but the first: the words of
// `depths` and `transmittances` are N = 4 kQuads nodes, sorted; `z` and `t` the fragment's depth and
// transmittance, in front of nodes of equal depth. Nodes of `empty` depth are unused.
template <int kQuads>
inline VectorInsertion insert_four_at_a_time(std::uint32_t* depths, std::uint32_t* transmittances, float z,
                                             float t, float empty) {
    constexpr int kNodes = 4 * kQuads;
    static_assert(kNodes < 32);
    const auto old_z = detail::loaded<kQuads>(depths);
    const auto old_v = detail::loaded<kQuads>(transmittances);
    const __m128 fragment = _mm_set1_ps(z);
    const __m128 factor = _mm_set1_ps(t);
    const auto front = detail::less_than(old_z, fragment);
    const auto front_before = detail::shifted_back(front, _mm_castsi128_ps(_mm_set1_epi32(-1)));
    const auto z_before = detail::shifted_back(old_z, fragment);
    const auto v_before = detail::shifted_back(old_v, _mm_set_ss(1.0f));
    const auto displaced = std::bit_cast<float>(depths[kNodes - 1]);
    const float last_z = displaced < z ? z : displaced;
    const float last_v = std::bit_cast<float>(transmittances[kNodes - 1]) * t;
    NodeQuads<kQuads> new_z;
    NodeQuads<kQuads> new_v;
#pragma GCC unroll 16
    for (int q = 0; q < kQuads; ++q) {
        const __m128 moved = detail::chosen(front_before.lane[q], fragment, z_before.lane[q]);
        new_z.lane[q] = detail::chosen(front.lane[q], old_z.lane[q], moved);
        new_v.lane[q] = detail::chosen(front.lane[q], old_v.lane[q], _mm_mul_ps(v_before.lane[q], factor));
    }
    const int place = std::countr_one(detail::sign_bits(front));
    if (!(last_z < empty)) {
        detail::store(new_z, depths);
        detail::store(new_v, transmittances);
        return {false, place};
    }
    const auto z_next = detail::shifted_front(new_z, _mm_set_ss(last_z));
    const auto v_next = detail::shifted_front(new_v, _mm_set_ss(last_v));
    const int removed = detail::least_error_node(new_z, new_v, z_next, v_next);
    const __m128i at = _mm_set1_epi32(removed);
    NodeQuads<kQuads> out_z;
    NodeQuads<kQuads> out_v;
#pragma GCC unroll 16
    for (int q = 0; q < kQuads; ++q) {
        const __m128i place_of = _mm_setr_epi32(4 * q, 4 * q + 1, 4 * q + 2, 4 * q + 3);
        const __m128 nearer = _mm_castsi128_ps(_mm_cmplt_epi32(place_of, at));
        // The node in front of the removed one takes its transmittance.
        const __m128 keeps =
            _mm_castsi128_ps(_mm_cmplt_epi32(_mm_add_epi32(place_of, _mm_set1_epi32(1)), at));
        out_z.lane[q] = detail::chosen(nearer, new_z.lane[q], z_next.lane[q]);
        out_v.lane[q] = detail::chosen(keeps, new_v.lane[q], v_next.lane[q]);
    }
    detail::store(out_z, depths);
    detail::store(out_v, transmittances);
    return {true, place < removed - 1 ? place : removed - 1};
}

// How many of the N = 4 kQuads sorted depths are less than z.
template <int kQuads>
inline int count_in_front(const std::uint32_t* depths, float z) {
    const auto front = detail::less_than(detail::loaded<kQuads>(depths), _mm_set1_ps(z));
    return std::countr_one(detail::sign_bits(front));
}

// The numbers of nodes that are inserted four at a time.
constexpr bool inserts_four_at_a_time(int nodes) {
    return nodes == 4 || nodes == 8 || nodes == 16;
}
inline VectorInsertion insert_four_at_a_time(int nodes, std::uint32_t* depths, std::uint32_t* transmittances,
                                             float z, float t, float empty) {
    switch (nodes) {
        case 4:
            return insert_four_at_a_time<1>(depths, transmittances, z, t, empty);
        case 8:
            return insert_four_at_a_time<2>(depths, transmittances, z, t, empty);
        default:
            return insert_four_at_a_time<4>(depths, transmittances, z, t, empty);
    }
}
inline int count_in_front(int nodes, const std::uint32_t* depths, float z) {
    switch (nodes) {
        case 4:
            return count_in_front<1>(depths, z);
        case 8:
            return count_in_front<2>(depths, z);
        default:
            return count_in_front<4>(depths, z);
    }
}

#else

constexpr bool inserts_four_at_a_time(int) {
    return false;
}
inline VectorInsertion insert_four_at_a_time(int, std::uint32_t*, std::uint32_t*, float, float, float) {
    return {};
}
inline int count_in_front(int, const std::uint32_t*, float) {
    return 0;
}

#endif

}  // namespace ropsim
