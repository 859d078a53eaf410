// Visibility as techniques keep it, at single pixels: weights, total transmittance, and what the order of
// arrival changes. Colour is composited here in double precision from the visibilities.
#pragma once

#include "analysis/pixel_run.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// Pixels of one fragment list each. Random layers: uniform depths and colours, in random order.
std::vector<PixelFragments> random_layers(int pixels, int layers, float alpha, std::uint64_t seed);
// Of a trace with one spatial sample: every `step`th of the pixels with `least` visible fragments or more.
std::vector<PixelFragments> sampled_pixels(const std::string& trace, int pixels, std::uint32_t least);

struct CurveStudyOptions {
    std::string technique;  // one that represents visibility
    int orders = 1;         // of arrival: as given, then random ones
    std::uint64_t seed = 1;
};

struct CurveStudy {
    // Of the curve at the fragments' depths, root mean square over fragments; 1 is full transmittance.
    double curve_rms = 0;
    // Colour against exact compositing over black, in 1/255.
    double mean8 = 0;
    double rms8 = 0;
    double weights_over_alpha = 0;  // sum of alpha times visibility over total alpha, mean of pixels
    double total_off = 0;           // largest difference of total transmittance from the product
    // Exact total alpha over the represented one, the factor that alpha correction applies: largest distance
    // from 1.
    double correction_off = 0;
    double near_half = 0;  // share of the steps that are kept in the nearer half of the fragments
    // How far the orders' images lie apart in 1/255: mean over pixels and channels.
    double spread8 = 0;
};

// Throws UserError for a technique that is misspelt; it must represent visibility (CHECK).
CurveStudy study_curves(const std::vector<PixelFragments>& pixels, const CurveStudyOptions& options);

}  // namespace ropsim
