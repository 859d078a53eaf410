// The keys that visibility maps share: opacity maps, Fourier opacity maps and occupancy maps used for
// transparency as Salvi et al. 2011, section 4, do.
#pragma once

#include "base/parameters.h"

#include <cstdint>

namespace ropsim {

// The depths between which a pixel's map lies.
enum class MapBounds : std::uint8_t {
    kPixel,    // between the pixel's nearest and furthest fragment: one more pass over the geometry
    kNearest,  // a given depth behind the pixel's nearest fragment (Yuksel and Keyser 2008); the same pass
    kFrame,    // the whole depth range: no pass
};

enum class MapMemory : std::uint8_t {
    kFixed,     // the map is in the framebuffer, geometry is drawn for bounds, map and colour
    kVariable,  // fragments are in lists, the map in registers while resolve walks them (section 4.1)
};

struct MapOptions {
    MapBounds bounds = MapBounds::kPixel;
    MapMemory memory = MapMemory::kFixed;
    bool normalised = false;    // the weights that visibility gives are scaled to the exact total alpha
    float depth_range = 0.05f;  // of MapBounds::kNearest
    int spatial_samples = 1;

    bool has_bounds() const { return bounds != MapBounds::kFrame; }
};

// Reads bounds=pixel|frame and composite=plain|normalised; `composite` is the latter's default.
MapOptions map_options(Parameters& parameters, int spatial_samples, const char* composite);
// Reads memory=fixed|variable.
MapMemory map_memory(Parameters& parameters);

}  // namespace ropsim
