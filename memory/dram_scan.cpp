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

std::uint64_t scan_pairs(const Keys& keys, const DramScanRange& range, const DramCycle* limit,
                         DramCycle floor) {
    const auto load = [](const std::uint64_t& from) {
        return _mm_load_pd(reinterpret_cast<const double*>(&from));
    };
    const __m128d low = bits(Keys::kTimeBias + floor);
    __m128d best = bits(Keys::kAbsent);
    std::uint32_t bank = range.bank;
    for (std::uint32_t g = 0; g < range.groups; ++g) {
        const __m128d between = bits(Keys::kTimeBias + limit[g]);
        for (const std::uint32_t end = bank + range.in_group; bank < end; bank += 2) {
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

[[gnu::target("avx2")]] inline __m256d four_bits(std::uint64_t value) {
    return _mm256_castsi256_pd(_mm256_set1_epi64x(static_cast<long long>(value)));
}

[[gnu::target("avx2")]] inline __m256d four_at(const std::uint64_t& first) {
    return _mm256_load_pd(reinterpret_cast<const double*>(&first));
}

// The keys of the four banks from `bank` on; `limit` four times their group's, as a biased time that `low`,
// the floor, is not above.
template <bool kAllBound>
[[gnu::target("avx2")]] inline __m256d four_keys(const Keys& keys, std::size_t bank, __m256d limit,
                                                 __m256d low) {
    const __m256d own = four_at(keys.time[bank]);
    const __m256d time =
        kAllBound ? _mm256_max_pd(limit, own)
                  : _mm256_max_pd(_mm256_max_pd(_mm256_and_pd(limit, four_at(keys.bound[bank])), own), low);
    const __m256i ahead = _mm256_sub_epi64(_mm256_castpd_si256(time), _mm256_castpd_si256(low));
    return _mm256_or_pd(_mm256_castsi256_pd(_mm256_slli_epi64(ahead, Keys::kTimeShift)),
                        four_at(keys.order[bank]));
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
    __m256d best = four_bits(Keys::kAbsent);
    for (std::size_t g = 0; g < range.groups; ++g) {
        const __m256d between = _mm256_max_pd(four_bits(Keys::kTimeBias + limit[g]), low);
        best = _mm256_min_pd(best, four_keys<kAllBound>(keys, range.bank + 4 * g, between, low));
    }
    return least_of_four(best);
}

// Four of them, the usual number: their limits, too, are looked at together.
template <bool kAllBound>
[[gnu::target("avx2")]] std::uint64_t scan_four_fours(const Keys& keys, const DramScanRange& range,
                                                      const DramCycle* limit, DramCycle floor) {
    const __m256i bias = _mm256_set1_epi64x(static_cast<long long>(Keys::kTimeBias));
    const __m256i limits = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(limit));
    const __m256d low = four_bits(Keys::kTimeBias + floor);
    const __m256d all = _mm256_max_pd(_mm256_castsi256_pd(_mm256_add_epi64(limits, bias)), low);
    const std::size_t bank = range.bank;
    const __m256d a = four_keys<kAllBound>(keys, bank, _mm256_permute4x64_pd(all, 0x00), low);
    const __m256d b = four_keys<kAllBound>(keys, bank + 4, _mm256_permute4x64_pd(all, 0x55), low);
    const __m256d c = four_keys<kAllBound>(keys, bank + 8, _mm256_permute4x64_pd(all, 0xaa), low);
    const __m256d d = four_keys<kAllBound>(keys, bank + 12, _mm256_permute4x64_pd(all, 0xff), low);
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
