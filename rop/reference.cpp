// Exact compositing: a band of tiles at a time is gathered by pixel, sorted and composited in double
// precision.
#include "rop/reference.h"

#include "base/error.h"
#include "base/parallel.h"
#include "rop/display_filter.h"
#include "traces/depth_key.h"
#include "traces/depth_test.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace ropsim {
namespace {

// Sorts like (z, arrival).
std::uint64_t order_key(float z, std::uint32_t index) {
    return std::uint64_t{depth_key(z)} << 32 | index;
}

using Rgb = std::array<float, 3>;

// The fragments of tiles [first_tile, last_tile) that pass the opaque depth test, grouped by pixel.
struct Band {
    int first_tile, last_tile;
    std::vector<Fragment> fragments;  // arrival order, coverage of the samples that pass
    std::vector<DepthSlope> slopes;   // theirs, where the trace has several samples
    std::vector<Rgb> transmissions;   // theirs, where they count
    std::vector<std::uint32_t>
        start;  // per pixel of the band (tile-major), into `order`; one more at the end
    std::vector<std::uint32_t> order;  // indices of fragments, arrival order within a pixel
};

class Compositor {
 public:
    Compositor(TraceReader& trace, int threads, DisplayFilter filter, std::uint64_t band_fragments,
               Transmission transmission)
        : trace_(trace),
          header_(trace.header()),
          depth_test_(trace.header()),
          threads_(threads),
          filter_(filter),
          band_fragments_(band_fragments),
          colored_(transmission == Transmission::kColored && header_.materials),
          across_(tiles_across(header_.width)),
          image_(header_.width, header_.height, {"R", "G", "B", "A", "layers", "ties"}) {}

    Image run() {
        if (filter_ != DisplayFilter::kBox)
            samples_.resize(pixel_index(0, header_.height) * static_cast<std::size_t>(header_.samples) * 4);
        const auto& counts = trace_.tile_fragments();
        const int tiles = static_cast<int>(counts.size());
        for (int first = 0; first < tiles;) {
            int last = first;
            std::uint64_t total = 0;
            do total += counts[static_cast<std::size_t>(last++)];
            while (last < tiles && total + counts[static_cast<std::size_t>(last)] <= band_fragments_);
            Band band{first, last, {}, {}, {}, {}, {}};
            if (total > 0) read(band, total, first == 0 && last == tiles);
            composite(band);
            first = last;
        }
        trace_.select_tiles({});
        trace_.rewind();
        if (filter_ != DisplayFilter::kBox) filter_samples();
        return std::move(image_);
    }

 private:
    std::size_t pixel_index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(header_.width) +
               static_cast<std::size_t>(x);
    }

    std::size_t band_pixel(const Band& band, const Fragment& f) const {
        const int tile = f.y / kTileSize * across_ + f.x / kTileSize - band.first_tile;
        const int within = f.y % kTileSize * kTileSize + f.x % kTileSize;
        return static_cast<std::size_t>(tile) * kTilePixels + static_cast<std::size_t>(within);
    }

    void read(Band& band, std::uint64_t total, bool everything) {
        std::vector<std::uint8_t> selected;
        if (!everything) {
            selected.resize(trace_.tile_fragments().size());
            std::fill(selected.begin() + band.first_tile, selected.begin() + band.last_tile, std::uint8_t{1});
        }
        trace_.select_tiles(std::move(selected));
        trace_.rewind();
        const auto pixels = static_cast<std::size_t>(band.last_tile - band.first_tile) * kTilePixels;
        band.start.assign(pixels + 1, 0);
        band.fragments.reserve(total);
        if (colored_) band.transmissions.reserve(total);
        FragmentChunk chunk;
        while (trace_.next(chunk, kSlopeChannels | (colored_ ? kMaterialChannels : kLeastAlpha))) {
            for (std::size_t i = 0; i < chunk.size(); ++i) {
                Fragment f = chunk.fragments[i];
                const DepthSlope slope = chunk.slopes.empty() ? DepthSlope{} : chunk.slopes[i];
                f.coverage = static_cast<std::uint16_t>(depth_test_.visible_samples(f, slope));
                if (f.coverage == 0) continue;  // draws nothing
                ++band.start[band_pixel(band, f) + 1];
                band.fragments.push_back(f);
                if (header_.samples > 1) band.slopes.push_back(slope);
                if (colored_) band.transmissions.push_back(std::to_array(chunk.materials[i].transmission));
            }
        }
        CHECK(band.fragments.size() <= 0xFFFFFFFFu, "{} fragments in one band", band.fragments.size());
        std::partial_sum(band.start.begin(), band.start.end(), band.start.begin());
        band.order.resize(band.fragments.size());
        std::vector<std::uint32_t> next(band.start.begin(), band.start.end() - 1);
        for (std::size_t i = 0; i < band.fragments.size(); ++i)
            band.order[next[band_pixel(band, band.fragments[i])]++] = static_cast<std::uint32_t>(i);
    }

    void composite(const Band& band) {
        constexpr int kTilesAPiece = 16;
        const int tiles = band.last_tile - band.first_tile;
        parallel_for(threads_, (tiles + kTilesAPiece - 1) / kTilesAPiece, [&](int piece) {
            std::vector<std::uint64_t> keys, here;
            const int end = std::min(tiles, (piece + 1) * kTilesAPiece);
            for (int i = piece * kTilesAPiece; i < end; ++i) composite_tile(band, i, keys, here);
        });
    }

    // `keys` and `here` are room to work in, kept from tile to tile.
    void composite_tile(const Band& band, int tile, std::vector<std::uint64_t>& keys,
                        std::vector<std::uint64_t>& here) {
        const int x0 = (band.first_tile + tile) % across_ * kTileSize,
                  y0 = (band.first_tile + tile) / across_ * kTileSize;
        for (int i = 0; i < kTilePixels; ++i) {
            const int x = x0 + i % kTileSize, y = y0 + i / kTileSize;
            if (x >= header_.width || y >= header_.height) continue;
            keys.clear();
            if (!band.start.empty()) {
                const auto p = static_cast<std::size_t>(tile) * kTilePixels + static_cast<std::size_t>(i);
                for (std::uint32_t k = band.start[p]; k < band.start[p + 1]; ++k)
                    keys.push_back(order_key(band.fragments[band.order[k]].z, band.order[k]));
                std::sort(keys.begin(), keys.end());
            }
            composite_pixel(band, keys, here, x, y);
        }
    }

    // What lies in front so far: its colour, what each channel lets through, and what is not covered.
    struct Sum {
        std::array<double, 3> color{}, through = {1, 1, 1};
        double uncovered = 1;

        void add(const Fragment& f, const Rgb& transmission) {
            const std::array<float, 3> rgb = {f.r, f.g, f.b};
            const auto alpha = static_cast<double>(f.a);
            for (std::size_t c = 0; c < 3; ++c) {
                color[c] += through[c] * static_cast<double>(rgb[c]);
                // 1 - a + a t, in the form that is 1 at t = 1 and the alpha reference's 1 - a at t = 0.
                through[c] *= 1.0 - alpha * (1.0 - static_cast<double>(transmission[c]));
            }
            uncovered *= 1.0 - alpha;
        }
    };

    void add(Sum& sum, const Band& band, std::uint64_t key) const {
        const std::size_t index = key & 0xFFFFFFFFu;
        sum.add(band.fragments[index], colored_ ? band.transmissions[index] : Rgb{});
    }

    // One sample's fragments, front to back by their depths there. `keys` orders by depth at the centre.
    Sum composite_sample(const Band& band, const std::vector<std::uint64_t>& keys,
                         std::vector<std::uint64_t>& here, int sample) const {
        Sum sum;
        if (header_.samples == 1) {
            for (const std::uint64_t key : keys) add(sum, band, key);
            return sum;
        }
        const SamplePosition position = sample_positions(header_.samples)[static_cast<std::size_t>(sample)];
        here.clear();
        for (const std::uint64_t key : keys) {
            const auto index = static_cast<std::uint32_t>(key);
            const Fragment& f = band.fragments[index];
            if ((f.coverage >> sample & 1) != 0)
                here.push_back(order_key(sample_depth(f, band.slopes[index], position), index));
        }
        std::sort(here.begin(), here.end());
        for (const std::uint64_t key : here) add(sum, band, key);
        return sum;
    }

    // Every sample on its own, then the mean of the samples.
    void composite_pixel(const Band& band, const std::vector<std::uint64_t>& keys,
                         std::vector<std::uint64_t>& here, int x, int y) {
        double r = 0, g = 0, b = 0, alpha = 0;
        for (int m = 0; m < header_.samples; ++m) {
            const Sum s = composite_sample(band, keys, here, m);
            const auto at =
                pixel_index(x, y) * static_cast<std::size_t>(header_.samples) + static_cast<std::size_t>(m);
            const float* behind = header_.opaque ? &header_.opaque->rgb[3 * at] : &header_.background.x;
            std::array<double, 4> color = {0, 0, 0, 1.0 - s.uncovered};
            for (std::size_t c = 0; c < 3; ++c)
                color[c] = s.color[c] + s.through[c] * static_cast<double>(behind[c]);
            r += color[0];
            g += color[1];
            b += color[2];
            alpha += color[3];
            if (samples_.empty()) continue;
            for (std::size_t c = 0; c < 4; ++c) samples_[4 * at + c] = static_cast<float>(color[c]);
        }
        int ties = 0;
        for (std::size_t k = 1; k < keys.size(); ++k) ties += keys[k] >> 32 == keys[k - 1] >> 32;
        float* out = image_.pixel(x, y);
        const double share = 1.0 / header_.samples;  // a power of two: exact
        out[0] = static_cast<float>(r * share);
        out[1] = static_cast<float>(g * share);
        out[2] = static_cast<float>(b * share);
        out[3] = static_cast<float>(alpha * share);
        out[4] = static_cast<float>(keys.size());
        out[5] = static_cast<float>(ties);
    }

    // Every pixel as the weighted sum of the samples around it; the image's border is repeated.
    void filter_samples() {
        const auto weights = filter_weights(filter_, header_.samples);
        parallel_for(threads_, header_.height, [&](int y) {
            for (int x = 0; x < header_.width; ++x) filter_pixel(weights, x, y);
        });
    }
    void filter_pixel(const std::vector<std::vector<double>>& weights, int x, int y) {
        const int reach = filter_footprint(filter_);
        std::array<double, 4> sum{};
        std::size_t number = 0;
        for (int dy = -reach; dy <= reach; ++dy) {
            for (int dx = -reach; dx <= reach; ++dx, ++number) {
                const std::vector<double>& weight = weights[number];
                const std::size_t pixel = pixel_index(std::clamp(x + dx, 0, header_.width - 1),
                                                      std::clamp(y + dy, 0, header_.height - 1));
                for (std::size_t m = 0; m < weight.size(); ++m)
                    for (std::size_t c = 0; c < 4; ++c)
                        sum[c] +=
                            weight[m] * static_cast<double>(samples_[4 * (pixel * weight.size() + m) + c]);
            }
        }
        for (std::size_t c = 0; c < 4; ++c) image_.pixel(x, y)[c] = static_cast<float>(sum[c]);
    }

    TraceReader& trace_;
    const TraceHeader& header_;
    OpaqueDepthTest depth_test_;
    int threads_;
    DisplayFilter filter_;
    std::uint64_t band_fragments_;
    bool colored_;  // fragments let through what their materials say
    int across_;
    Image image_;
    std::vector<float> samples_;  // R, G, B, A of each, where a filter asks for them
};

}  // namespace

Image reference_image(TraceReader& trace, int threads, DisplayFilter filter, std::uint64_t band_fragments,
                      Transmission transmission) {
    return Compositor(trace, threads, filter, band_fragments, transmission).run();
}

}  // namespace ropsim
