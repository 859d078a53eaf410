// Gives the fragments of a foreign deep image an arrival order, and hands them on in rounds.
#include "base/random.h"
#include "traces/depth_key.h"
#include "traces/interchange/deep_exr_foreign.h"

#include <algorithm>
#include <numeric>

namespace ropsim {

namespace {

constexpr std::size_t kPiece = 1u << 16;

// Arrival order within one pixel after another.
class PixelOrder {
 public:
    PixelOrder(const ForeignDeepImage& image, DeepOrder order, std::uint64_t seed)
        : image_(image), order_(order), seed_(mix64(seed + 0x9E3779B97F4A7C15ull)) {}

    // Writes the indices of the fragments [first, last) into out[first, last).
    void sort(std::uint32_t first, std::uint32_t last, std::vector<std::uint32_t>& out) {
        const auto begin = out.begin() + first;
        std::iota(begin, out.begin() + last, first);
        if (order_ == DeepOrder::kFile || last - first < 2) return;
        keys_.clear();
        for (std::uint32_t i = first; i < last; ++i) {
            const std::uint32_t depth = depth_key(image_.fragments[i].z);
            keys_.push_back({order_ == DeepOrder::kFarToNear ? ~depth : depth, i});
        }
        std::sort(keys_.begin(), keys_.end());
        if (order_ == DeepOrder::kShuffle) shuffle();
        for (std::uint32_t k = 0; k < last - first; ++k) begin[k] = keys_[k].second;
    }

 private:
    // Random keys, sorted among fragments of one depth: those keep the file's order.
    void shuffle() {
        random_.clear();
        for (const auto& [depth, index] : keys_) random_.push_back({mix64(seed_ + index), index});
        for (std::size_t from = 0; from < keys_.size();) {
            std::size_t to = from + 1;
            while (to < keys_.size() && keys_[to].first == keys_[from].first) ++to;
            if (to - from > 1) {
                tied_.clear();
                for (std::size_t i = from; i < to; ++i) tied_.push_back(random_[i].first);
                std::sort(tied_.begin(), tied_.end());
                for (std::size_t i = from; i < to; ++i) random_[i].first = tied_[i - from];
            }
            from = to;
        }
        std::sort(random_.begin(), random_.end());
        for (std::size_t i = 0; i < keys_.size(); ++i) keys_[i].second = random_[i].second;
    }

    const ForeignDeepImage& image_;
    const DeepOrder order_;
    const std::uint64_t seed_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> keys_;    // depth, index
    std::vector<std::pair<std::uint64_t, std::uint32_t>> random_;  // key, index
    std::vector<std::uint64_t> tied_;
};

// Calls visit(x, y) for every pixel: tile by tile, in a tile quad by quad.
template <typename Visit>
void for_each_pixel(int width, int height, Visit&& visit) {
    for (int top = 0; top < height; top += kTileSize)
        for (int left = 0; left < width; left += kTileSize)
            for (int i = 0; i < kTilePixels; ++i) {
                const int quad = i / 4;
                const int x = left + quad % 4 * 2 + i % 2;
                const int y = top + quad / 4 * 2 + i / 2 % 2;
                if (x < width && y < height) visit(x, y);
            }
}

}  // namespace

void emit_in_rounds(const ForeignDeepImage& image, DeepOrder order, std::uint64_t seed,
                    const std::function<void(const std::vector<Fragment>&)>& sink) {
    std::vector<std::uint32_t> sorted(image.fragments.size());
    PixelOrder pixels(image, order, seed);
    struct Rest {
        std::uint32_t next, end;
    };
    std::vector<Rest> rests;  // what each pixel still has to give, into `sorted`
    for_each_pixel(image.header.width, image.header.height, [&](int x, int y) {
        const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.header.width) +
                                  static_cast<std::size_t>(x);
        const Rest rest{image.start[pixel], image.start[pixel + 1]};
        if (rest.next == rest.end) return;
        pixels.sort(rest.next, rest.end, sorted);
        rests.push_back(rest);
    });
    std::vector<Fragment> piece;
    while (!rests.empty()) {
        std::size_t kept = 0;
        for (Rest rest : rests) {
            piece.push_back(image.fragments[sorted[rest.next++]]);
            if (rest.next != rest.end) rests[kept++] = rest;
            if (piece.size() < kPiece) continue;
            sink(piece);
            piece.clear();
        }
        rests.resize(kept);
    }
    if (!piece.empty()) sink(piece);
}

}  // namespace ropsim
