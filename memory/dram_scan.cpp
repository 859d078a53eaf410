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

std::uint64_t scan_pairs(const Keys& keys, std::uint32_t bank, std::uint32_t groups, std::uint32_t in_group,
                         const DramCycle* limit, DramCycle floor) {
    const auto load = [](const std::uint64_t& from) {
        return _mm_load_pd(reinterpret_cast<const double*>(&from));
    };
    const __m128d low = bits(Keys::kTimeBias + floor);
    __m128d best = bits(Keys::kAbsent);
    for (std::uint32_t g = 0; g < groups; ++g) {
        const __m128d between = bits(Keys::kTimeBias + limit[g]);
        for (const std::uint32_t end = bank + in_group; bank < end; bank += 2) {
            const __m128d bound = _mm_and_pd(between, load(keys.bound[bank]));
            const __m128d time = _mm_max_pd(_mm_max_pd(bound, load(keys.time[bank])), low);
            const __m128i ahead = _mm_sub_epi64(_mm_castpd_si128(time), _mm_castpd_si128(low));
            const __m128i key = _mm_slli_epi64(ahead, Keys::kTimeShift);
            best = _mm_min_pd(best, _mm_or_pd(_mm_castsi128_pd(key), load(keys.order[bank])));
        }
    }
    best = _mm_min_sd(best, _mm_unpackhi_pd(best, best));
    return static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm_castpd_si128(best)));
}

// Groups of four, the usual size; kGroups of them, or `groups` if that is 0.
template <std::uint32_t kGroups>
[[gnu::target("avx2")]] inline std::uint64_t least_of_fours(const Keys& keys, std::uint32_t bank,
                                                            std::uint32_t groups, const DramCycle* limit,
                                                            DramCycle floor) {
    const __m256i bias = _mm256_set1_epi64x(static_cast<long long>(Keys::kTimeBias));
    const __m256i low = _mm256_add_epi64(bias, _mm256_set1_epi64x(static_cast<long long>(floor)));
    __m256d best = _mm256_castsi256_pd(_mm256_set1_epi64x(static_cast<long long>(Keys::kAbsent)));
    const auto* bounds = reinterpret_cast<const double*>(&keys.bound[bank]);
    const auto* times = reinterpret_cast<const double*>(&keys.time[bank]);
    const auto* orders = reinterpret_cast<const double*>(&keys.order[bank]);
#pragma GCC unroll 4
    for (std::size_t g = 0; g < (kGroups == 0 ? groups : kGroups); ++g) {
        const __m256i between = _mm256_set1_epi64x(static_cast<long long>(limit[g]));
        const __m256d bound = _mm256_and_pd(_mm256_castsi256_pd(_mm256_add_epi64(bias, between)),
                                            _mm256_load_pd(bounds + 4 * g));
        const __m256d own = _mm256_max_pd(bound, _mm256_load_pd(times + 4 * g));
        const __m256d time = _mm256_max_pd(own, _mm256_castsi256_pd(low));
        const __m256i ahead = _mm256_sub_epi64(_mm256_castpd_si256(time), low);
        const __m256d key = _mm256_castsi256_pd(_mm256_slli_epi64(ahead, Keys::kTimeShift));
        best = _mm256_min_pd(best, _mm256_or_pd(key, _mm256_load_pd(orders + 4 * g)));
    }
    const __m128d half = _mm_min_pd(_mm256_castpd256_pd128(best), _mm256_extractf128_pd(best, 1));
    const __m128d one = _mm_min_sd(half, _mm_unpackhi_pd(half, half));
    return static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm_castpd_si128(one)));
}

[[gnu::target("avx2")]] std::uint64_t scan_fours(const Keys& keys, std::uint32_t bank, std::uint32_t groups,
                                                 std::uint32_t, const DramCycle* limit, DramCycle floor) {
    if (groups == 4) [[likely]]
        return least_of_fours<4>(keys, bank, groups, limit, floor);
    return least_of_fours<0>(keys, bank, groups, limit, floor);
}

}  // namespace
#endif

std::vector<DramScan> dram_scans(std::uint32_t in_group) {
    std::vector<DramScan> scans;
#ifdef __SSE2__
    if (in_group % 2 == 0) scans.push_back(scan_pairs);
    if (in_group == 4 && __builtin_cpu_supports("avx2")) scans.push_back(scan_fours);
#else
    (void)in_group;
#endif
    return scans;
}

DramScan dram_scan_for(std::uint32_t in_group) {
    const std::vector<DramScan> scans = dram_scans(in_group);
    return scans.empty() ? nullptr : scans.back();
}

}  // namespace ropsim
