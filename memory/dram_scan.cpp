// See dram_scan.h. Wider vectors are chosen at run time and give the same result.
#include "memory/dram_scan.h"

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace ropsim {

#ifdef __SSE2__
namespace {

using Keys = DramScanKeys;

inline __m128d bits(std::uint64_t value) {
    return _mm_castsi128_pd(_mm_set1_epi64x(static_cast<long long>(value)));
}

inline __m128d key_at(const Keys::Key& key) {
    return _mm_load_pd(reinterpret_cast<const double*>(&key));
}

std::uint64_t scan_pairs(const Keys& keys, const DramScanRange& range, const DramCycle* limit,
                         DramCycle floor) {
    const __m128d low = bits(Keys::kTimeBias + floor);
    const __m128d unbound = bits(Keys::kUnbound);
    __m128d best = bits(Keys::kAbsent);
    const Keys::Key* key = keys.from(range.bank);
    for (std::uint32_t g = 0; g < range.groups; ++g) {
        const __m128d between = bits(Keys::kTimeBias + limit[g]);
        for (const Keys::Key* const end = key + range.in_group; key < end; key += 2) {
            const __m128d time = _mm_unpacklo_pd(key_at(key[0]), key_at(key[1]));
            const __m128d bound = _mm_andnot_pd(_mm_cmplt_pd(time, _mm_setzero_pd()), between);
            const __m128d earliest = _mm_max_pd(_mm_max_pd(bound, _mm_andnot_pd(unbound, time)), low);
            const __m128i ahead = _mm_sub_epi64(_mm_castpd_si128(earliest), _mm_castpd_si128(low));
            const __m128d shifted = _mm_castsi128_pd(_mm_slli_epi64(ahead, Keys::kTimeShift));
            best = _mm_min_pd(best, _mm_or_pd(shifted, _mm_unpackhi_pd(key_at(key[0]), key_at(key[1]))));
        }
    }
    best = _mm_min_sd(best, _mm_unpackhi_pd(best, best));
    return static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm_castpd_si128(best)));
}

[[gnu::target("avx2")]] inline __m256d four_bits(std::uint64_t value) {
    return _mm256_castsi256_pd(_mm256_set1_epi64x(static_cast<long long>(value)));
}

// The keys of the four banks from `key` on; `limit` four times their group's, as a biased time that `low`,
// the floor, is not above.
template <bool kAllBound>
[[gnu::target("avx2")]] inline __m256d four_keys(const Keys::Key* key, __m256d limit, __m256d low) {
    const __m256d even = _mm256_insertf128_pd(_mm256_castpd128_pd256(key_at(key[0])), key_at(key[2]), 1);
    const __m256d odd = _mm256_insertf128_pd(_mm256_castpd128_pd256(key_at(key[1])), key_at(key[3]), 1);
    __m256d time = _mm256_unpacklo_pd(even, odd);
    if constexpr (kAllBound) {
        time = _mm256_max_pd(limit, time);
    } else {
        const __m256d own = _mm256_andnot_pd(four_bits(Keys::kUnbound), time);
        time = _mm256_max_pd(_mm256_blendv_pd(limit, low, time), own);
    }
    const __m256i ahead = _mm256_sub_epi64(_mm256_castpd_si256(time), _mm256_castpd_si256(low));
    return _mm256_or_pd(_mm256_castsi256_pd(_mm256_slli_epi64(ahead, Keys::kTimeShift)),
                        _mm256_unpackhi_pd(even, odd));
}

// A group's limit, no lower than `low`.
[[gnu::target("avx2")]] inline __m256d four_limits(DramCycle limit, __m256d low) {
    return _mm256_max_pd(four_bits(Keys::kTimeBias + limit), low);
}

[[gnu::target("avx2")]] inline std::uint64_t least_of_four(__m256d keys) {
    const __m128d half = _mm_min_pd(_mm256_castpd256_pd128(keys), _mm256_extractf128_pd(keys, 1));
    const __m128d one = _mm_min_sd(half, _mm_unpackhi_pd(half, half));
    return static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm_castpd_si128(one)));
}

// Groups of four.
template <bool kAllBound>
[[gnu::target("avx2")]] std::uint64_t scan_fours(const Keys& keys, const DramScanRange& range,
                                                 const DramCycle* limit, DramCycle floor) {
    const __m256d low = four_bits(Keys::kTimeBias + floor);
    const Keys::Key* const key = keys.from(range.bank);
    __m256d best = four_bits(Keys::kAbsent);
    for (std::size_t g = 0; g < range.groups; ++g)
        best = _mm256_min_pd(best, four_keys<kAllBound>(key + 4 * g, four_limits(limit[g], low), low));
    return least_of_four(best);
}

// Four of them, the usual number.
template <bool kAllBound>
[[gnu::target("avx2")]] std::uint64_t scan_four_fours(const Keys& keys, const DramScanRange& range,
                                                      const DramCycle* limit, DramCycle floor) {
    const __m256d low = four_bits(Keys::kTimeBias + floor);
    const Keys::Key* const key = keys.from(range.bank);
    const __m256d a = four_keys<kAllBound>(key, four_limits(limit[0], low), low);
    const __m256d b = four_keys<kAllBound>(key + 4, four_limits(limit[1], low), low);
    const __m256d c = four_keys<kAllBound>(key + 8, four_limits(limit[2], low), low);
    const __m256d d = four_keys<kAllBound>(key + 12, four_limits(limit[3], low), low);
    return least_of_four(_mm256_min_pd(_mm256_min_pd(a, b), _mm256_min_pd(c, d)));
}

}  // namespace
#endif

std::vector<DramScan> dram_scans(std::uint32_t groups, std::uint32_t in_group, bool all_bound) {
    std::vector<DramScan> scans;
#ifdef __SSE2__
    if (in_group % 2 == 0) scans.push_back(scan_pairs);
    if (in_group == 4 && __builtin_cpu_supports("avx2")) {
        scans.push_back(all_bound ? scan_fours<true> : scan_fours<false>);
        if (groups == 4) scans.push_back(all_bound ? scan_four_fours<true> : scan_four_fours<false>);
    }
#else
    (void)groups;
    (void)in_group;
    (void)all_bound;
#endif
    return scans;
}

DramScan dram_scan_for(std::uint32_t groups, std::uint32_t in_group, bool all_bound) {
    const std::vector<DramScan> scans = dram_scans(groups, in_group, all_bound);
    return scans.empty() ? nullptr : scans.back();
}

}  // namespace ropsim
