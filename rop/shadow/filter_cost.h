// What filtering a stochastic shadow map costs in fetches and bytes: once a map, by conversion, or once a
// look-up, by fetching the kernel's texels (McGuire and Mara 2017, section 8.1).
#pragma once

#include "rop/shadow/variance_options.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

struct MapShape {
    std::uint64_t width = 0, height = 0;  // texels
    std::uint64_t samples = 1;            // stored depths a texel a wavelength
    std::uint64_t wavelengths = 3;
    std::uint64_t depth_bytes = 4;  // of one stored depth
};

// One image pass over every wavelength.
struct ConversionPass {
    std::string name;
    std::uint64_t output_texels = 0;   // made
    std::uint64_t fetches = 0;         // texels (or, where depths are squared, depths) read
    std::uint64_t read_bytes = 0;      // by those fetches, before any cache
    std::uint64_t distinct_bytes = 0;  // behind a perfect cache: each texel that is read, once
    std::uint64_t write_bytes = 0;
};

// The passes of a conversion in their order. Texels beyond the border cost a fetch and, alone among all, no
// distinct bytes.
std::vector<ConversionPass> conversion_passes(const MapShape& map, const VarianceOptions& options);

// Fetches of one look-up, one wavelength, by the look-up's kind. A bilinear fetch is one fetch of 4 texels.
struct LookupCost {
    double fetches = 0;
    double bytes = 0;  // before any cache
};
LookupCost variance_lookup_cost(const VarianceOptions& options);
LookupCost direct_lookup_cost(double fetches, const MapShape& map);

// Texel centres within a disc of diameter `side` about a texel's centre: 177 at 15, where the area, pi 7.5^2,
// is 176.7. "Around 176 texture fetches" of section 8.1 is this disc; a 15 x 15 tent has 225 texels.
int disc_texels(int side);

// Bytes for `lookups` look-ups of every wavelength, both ways.
struct FilterSaving {
    double direct_bytes = 0;      // all of it in look-ups
    double conversion_bytes = 0;  // read (behind a perfect cache, or not) and written
    double lookup_bytes = 0;
    double ratio() const { return direct_bytes / (conversion_bytes + lookup_bytes); }
};
// `cached`: of the conversion's reads each texel counts once. Bytes of look-ups are before caches both ways,
// as the paper counts them; `bilinear_as_one`: a bilinear fetch counts as one texel's bytes.
FilterSaving filter_saving(const MapShape& map, const VarianceOptions& options, double lookups,
                           double direct_fetches, bool cached, bool bilinear_as_one);
// Look-ups at which the ratio is `ratio`; negative where no number of them reaches it.
double lookups_for_saving(const MapShape& map, const VarianceOptions& options, double ratio,
                          double direct_fetches, bool cached, bool bilinear_as_one);

}  // namespace ropsim
