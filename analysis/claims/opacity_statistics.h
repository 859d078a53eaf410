// What the opacity reference values of Laine and Karras 2011, section 3, are like: spans, coverage,
// correlation.
#pragma once

#include "rop/sampling/opacity_reference.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// Whether every aligned span of 2^k indices, k = 1..10, has one reference in each of 2^k equal intervals:
// over `spans` spans at random places for each k and surface 0..63.
bool aligned_spans_stratified(OpacityHash hash, int spans);

// The same of a sequence that is printed: every aligned span of 2, 4, ... of it.
bool spans_stratified(const std::vector<double>& sequence);

// Greatest distance of the number of samples that one surface covers from floor or ceil(alpha samples), over
// `trials` pixels, surfaces and alphas.
int farthest_from_share(int samples, int trials);

// Mean coverage of `pixels` pixels by `surfaces` surfaces of one alpha, farther ones first, with nothing but
// the sequence, and its standard error.
struct Coverage {
    double mean = 0;
    double standard_error = 0;
};
Coverage mean_coverage(OpacityHash hash, double alpha, int surfaces, int samples, int pixels);

// Largest correlation between the references of surface 0 and of surfaces 1..8, over `indices` indices.
double largest_correlation(OpacityHash hash, int indices);

}  // namespace ropsim
