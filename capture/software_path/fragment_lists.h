// Per-pixel linked lists of the visible fragments, made by atomics and put into arrival order: what
// techniques work on that need an ordered pass over the screen.
#pragma once

#include "capture/software_path/arrivals.h"
#include "capture/software_path/render_targets.h"
#include "capture/software_path/software_technique.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace ropsim {

// A node as GLSL has it (shaders/software_path/fragment_lists.glsl).
struct ListedFragment {
    float z = 0;  // of the plane at the pixel's centre
    float premultiplied[3] = {};
    float alpha = 0;
    std::uint32_t primitive = 0;      // with kBackFacing
    std::uint32_t coverage_draw = 0;  // visible samples, draw << 16
    std::uint32_t order = 0;
    float slope[2] = {};
    std::uint32_t next = 0;  // number of a node, 0: none
    std::uint32_t pixel = 0;
};
static_assert(sizeof(ListedFragment) == 48);

class GpuFragmentLists {
 public:
    // `nodes`: at most so many at a time; 0: as many as the driver allows, at most 2^21.
    explicit GpuFragmentLists(Arrivals& arrivals, std::size_t nodes = 0);

    // Calls body() for bands of the screen, from the top, each with its lists bound and the scissor around
    // it. Everything that body() draws over the screen sees whole lists of its pixels. Throws UserError where
    // one row has more fragments than there may be nodes.
    void for_bands(const std::function<void()>& body);
    // Those of one pixel, in arrival order.
    std::vector<ListedFragment> at(int x, int y);
    // One byte a pixel, row by row: whether any pixel of its 8x8 tile has a visible fragment that shows, that
    // is, of some alpha or colour. Draws all fragments once.
    std::vector<std::uint8_t> touched_tiles();

 private:
    struct Band {
        int y = 0;
        int rows = 0;
    };
    std::vector<Band> bands();
    void count_fragments();
    void fill(int x, int y, int width, int rows);

    Arrivals& arrivals_;
    std::size_t capacity_;
    GlBuffer nodes_;
    GlBuffer heads_;
    GlTarget nothing_;
    std::unique_ptr<ArrivalPass> append_;
    ScreenPass order_;
    std::vector<float> counts_;   // fragments a pixel; empty until drawn
    std::vector<float> showing_;  // those of some alpha or colour
};

// Text for a ScreenPass inside for_bands(): `shaders`, of which the last defines `vec3 resolved(ivec2 pixel)`
// (see resolve_text()) and all may use fragment_lists.glsl. `defines`: lines before it.
std::string list_pass_text(const std::vector<const char*>& shaders, StoredAs stored,
                           const std::string& defines = {});
// The image that such a pass makes. `seed`: its uniforms u_seed_low and u_seed_high, if it has them.
Image image_from_lists(Arrivals& arrivals, const std::vector<const char*>& shaders, StoredAs stored,
                       const std::string& defines = {}, std::uint64_t seed = 0);

}  // namespace ropsim
