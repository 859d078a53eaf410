// Reads that a resolve or an image pass makes of pixels whose place it computes itself: distorted and blurred
// backgrounds, upsampling. What is read is collected, for the counts and for timing.
#pragma once

#include "rop/gather_reads.h"
#include "rop/pixel.h"
#include "rop/technique_input.h"
#include "rop/window.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

// The image around a pixel as such an operation sees it. Reads of other pixels are of whole surfaces.
template <class P>
class Gather {
 public:
    using D = typename P::D;
    // `own`: the pixel at (x, y), of which reads and writes are counted as everywhere else.
    Gather(const StoreMap& stores, P own, int x, int y, GatherReads& reads, bool worst)
        : stores_(stores), own_(own), x_(x), y_(y), reads_(reads), worst_(worst) {}
    ~Gather() { flush(); }
    Gather(const Gather&) = delete;
    Gather& operator=(const Gather&) = delete;

    P& own() { return own_; }
    int x() const { return x_; }
    int y() const { return y_; }
    int width() const { return stores_.width(); }
    int height() const { return stores_.height(); }

    // The pixel at (x, y), inside the image; read only, until the next call.
    P at(int x, int y) {
        flush();
        tap_x_ = x;
        tap_y_ = y;
        const std::uint32_t* words = stores_.store(x, y).find_pixel(x, y);
        if (words == nullptr) {
            stores_.store(x, y).copy_pixel(x, y, untouched_);
            words = untouched_.data();
        }
        // A pixel is both read and written through; this one is only read.
        auto* const readable = const_cast<std::uint32_t*>(words);
        if constexpr (D::kCharged)
            return P(readable, tap_, nullptr, worst_);
        else
            return P(readable, tap_, nullptr);
    }
    // Mean colour of the opaque layer at (x, y), inside the image.
    Rgb<D> background(int x, int y) {
        ++reads_.backgrounds;
        if (reads_.record) add(x, y, GatherRead::kBackground);
        const glm::vec3 c = stores_.store(x, y).mean_background(x, y);
        if constexpr (D::kCharged)
            return {{c.r, stage_ready_}, {c.g, stage_ready_}, {c.b, stage_ready_}};
        else
            return {c.r, c.g, c.b};
    }
    // Depth of the opaque layer at (x, y), inside the image; +infinity where there is none.
    typename D::Real opaque_depth(int x, int y) {
        ++reads_.opaque_depths;
        if (reads_.record) add(x, y, GatherRead::kOpaqueDepth);
        return stores_.store(x, y).opaque_depth(x, y, 0);
    }
    // Backgrounds asked for from here on lie at places that depend on what has been loaded.
    void next_fetch_stage([[maybe_unused]] typename D::Bool after) {
        if constexpr (D::kCharged)
            stage_ready_ = Ledger::active().charge(Unit::kFetchStage, std::max(stage_ready_, after.ready));
    }

 private:
    void add(int x, int y, std::uint8_t surface) {
        reads_.reads.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), surface});
    }
    void flush() {
        for (std::size_t s = 0; s < kMaxTechniqueSurfaces; ++s) {
            if (tap_[s].read == 0) continue;
            tap_[s].read = 0;
            ++reads_.pixels[s];
            if (reads_.record) add(tap_x_, tap_y_, static_cast<std::uint8_t>(s));
        }
    }

    const StoreMap& stores_;
    P own_;
    int x_, y_;
    GatherReads& reads_;
    bool worst_;
    int stage_ready_ = 0;
    int tap_x_ = 0;
    int tap_y_ = 0;
    PixelAccess tap_{};
    std::vector<std::uint32_t> untouched_;
};

}  // namespace ropsim
