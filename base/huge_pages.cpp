#include "base/huge_pages.h"

#include <algorithm>
#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace ropsim {

namespace {
constexpr std::size_t kLine = 64;
constexpr std::size_t kFirstSlab = std::size_t{64} << 10;
}  // namespace

void prefer_huge_pages([[maybe_unused]] void* data, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    // Only pages that lie wholly inside are anybody's to advise on.
    const auto start = reinterpret_cast<std::uintptr_t>(data);
    const std::uintptr_t first = (start + kHugePage - 1) / kHugePage * kHugePage;
    const std::uintptr_t end = (start + bytes) / kHugePage * kHugePage;
    if (first < end) madvise(static_cast<std::byte*>(data) + (first - start), end - first, MADV_HUGEPAGE);
#endif
}

void Slabs::Free::operator()(std::uint32_t* words) const {
    std::free(words);
}

std::uint32_t* Slabs::take(std::size_t count) {
    constexpr std::size_t kLineWords = kLine / sizeof(std::uint32_t);
    count = (count + kLineWords - 1) / kLineWords * kLineWords;
    if (count > left_) {
        slab_bytes_ = std::min(slab_bytes_ == 0 ? kFirstSlab : 2 * slab_bytes_, 2 * kHugePage);
        const std::size_t bytes = std::max(slab_bytes_, count * sizeof(std::uint32_t));
        void* slab = std::aligned_alloc(bytes % kHugePage == 0 ? kHugePage : kLine, bytes);
        if (slab == nullptr) throw std::bad_alloc();
        slabs_.emplace_back(static_cast<std::uint32_t*>(slab));
        prefer_huge_pages(slabs_.back().get(), bytes);
        next_ = slabs_.back().get();
        left_ = bytes / sizeof(std::uint32_t);
    }
    std::uint32_t* taken = next_;
    next_ += count;
    left_ -= count;
    return taken;
}

}  // namespace ropsim
