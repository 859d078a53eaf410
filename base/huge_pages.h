// Memory that is used at random or all at once: in large pages where the system has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace ropsim {

inline constexpr std::size_t kHugePage = std::size_t{2} << 20;

// Asks for large pages in [data, data + bytes), before it is first written: fewer faults, fewer misses of the
// address translation. A hint that changes no result; nothing where the system has none.
void prefer_huge_pages(void* data, std::size_t bytes);

// Hands out memory that lives as long as the slabs do, from pieces that grow with what has been taken.
class Slabs {
 public:
    // `count` words, not initialised, at the start of a cache line.
    std::uint32_t* take(std::size_t count);

 private:
    struct Free {
        void operator()(std::uint32_t* words) const;
    };
    std::vector<std::unique_ptr<std::uint32_t[], Free>> slabs_;
    std::uint32_t* next_ = nullptr;
    std::size_t left_ = 0;  // words
    std::size_t slab_bytes_ = 0;
};

}  // namespace ropsim
