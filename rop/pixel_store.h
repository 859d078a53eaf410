// The pixel state of one partition's tiles, allocated and initialised at a tile's first touch.
#pragma once

#include "base/huge_pages.h"
#include "rop/declaration.h"
#include "rop/node_pool.h"
#include "traces/trace.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace ropsim {

inline constexpr int kMaxSpatialSamples = 16;

// What is behind a pixel, sample by sample and on average.
struct PixelBackground {
    int samples = 1;
    glm::vec3 mean{0.0f};
    std::array<glm::vec3, kMaxSpatialSamples> sample;  // the first `samples`
};

// A word of each pixel that depends on its place and on the mean colour behind it alone.
using PixelConstant = std::function<std::uint32_t(int x, int y, glm::vec3 background)>;

class PixelStore {
 public:
    // `constant_of`, if given, is kept as an extra word of each pixel (a technique's pixel index). The
    // trace header must outlive the store.
    PixelStore(const Declaration& declaration, const TraceHeader& trace, std::uint64_t pool_nodes,
               PixelConstant constant_of = nullptr);

    // Functional words of a pixel; its tile is allocated on first use.
    std::uint32_t* pixel(int x, int y) {
        const std::size_t tile = tile_of(x, y);
        std::uint32_t* words = tiles_[tile];
        if (words == nullptr) [[unlikely]]
            words = touch(tile);
        return words + place_in_tile(x, y) * pixel_words_;
    }
    // Asks for a pixel's words, if its tile is there, before an operation needs them. In line always: GCC
    // sees a function without effects, and drops the call, before it looks inside.
    [[gnu::always_inline]] void prefetch(int x, int y) const {
        const std::uint32_t* words = tiles_[tile_of(x, y)];
        if (words == nullptr) return;
        words += place_in_tile(x, y) * pixel_words_;
        constexpr std::size_t kLineWords = 16;
        for (std::size_t w = 0; w < pixel_words_; w += kLineWords) __builtin_prefetch(words + w);
    }
    bool touched(int tile_x, int tile_y) const {
        return tiles_[static_cast<std::size_t>(tile_y) * static_cast<std::size_t>(tiles_across_) +
                      static_cast<std::size_t>(tile_x)] != nullptr;
    }
    std::uint64_t touched_tiles() const { return touched_tiles_; }
    NodePool* pool() { return pool_.get(); }
    const TraceHeader& trace() const { return trace_; }
    // Index of the constant's word in a pixel, where it has one.
    std::size_t constant_word() const { return pixel_words_ - 1; }

    // Sets these surfaces (numbers of the declaration) to their initial contents, in all touched tiles, or
    // those of them with selected[tile] != 0 if any are given.
    void restore(std::span<const int> surfaces, std::span<const std::uint8_t> selected = {});
    // A pixel's functional words where its tile is touched, else nullptr.
    const std::uint32_t* find_pixel(int x, int y) const {
        const std::uint32_t* words = tiles_[tile_of(x, y)];
        return words == nullptr ? nullptr : words + place_in_tile(x, y) * pixel_words_;
    }
    // A pixel's functional words, initial ones where its tile is not touched; touches nothing.
    void copy_pixel(int x, int y, std::vector<std::uint32_t>& words) const;
    // A pixel's functional words as the frame starts with them.
    void initial_pixel(int x, int y, std::vector<std::uint32_t>& words) const {
        words.resize(pixel_words_);
        initialise(words.data(), x, y);
    }
    PixelBackground background(int x, int y) const;
    glm::vec3 mean_background(int x, int y) const;
    // +infinity where nothing opaque was drawn.
    float opaque_depth(int x, int y, int sample) const;

 private:
    // Of unsigned numbers, whose division by a tile's size is a shift.
    std::size_t tile_of(int x, int y) const {
        return static_cast<std::size_t>(y) / kTileSize * static_cast<std::size_t>(tiles_across_) +
               static_cast<std::size_t>(x) / kTileSize;
    }
    static std::size_t place_in_tile(int x, int y) {
        return static_cast<std::size_t>(y) % kTileSize * kTileSize + static_cast<std::size_t>(x) % kTileSize;
    }
    std::uint32_t* touch(std::size_t tile);
    void initialise(std::uint32_t* words, int x, int y) const;
    void initialise(const Surface& surface, std::uint32_t* words, int x, int y) const;
    glm::vec3 sample_background(int x, int y, int sample) const;

    const Declaration& declaration_;
    const TraceHeader& trace_;
    PixelConstant constant_of_;
    int tiles_across_;
    std::size_t pixel_words_;
    std::vector<std::uint32_t> cleared_;  // a pixel's words as cleared
    Slabs memory_;
    std::vector<std::uint32_t*> tiles_;  // null where nothing has touched them
    std::uint64_t touched_tiles_ = 0;
    std::unique_ptr<NodePool> pool_;
};

}  // namespace ropsim
