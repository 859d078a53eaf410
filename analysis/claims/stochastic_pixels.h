// Pixels that Enderton et al. 2011 reckon with, what their estimates come to over all masks, and rows of it.
#pragma once

#include "analysis/claims/list.h"
#include "analysis/claims/mask_enumeration.h"

#include <array>
#include <vector>

namespace ropsim::stochastic_claims {

using Values = std::vector<double>;

// Red over green, both .45, over blue.
MaskPixel example1();
// Four white layers of 1/4 over 1/4.
MaskPixel example2(int samples = 4);
// Section 4.1: red over green, both 1/4, over black.
MaskPixel two_quarters();

// Of the three channels.
Values three(const std::array<double, 3>& values);
// RMS errors and means.
Values rms(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate);
Values mean(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate);
// Largest distance of a mean from the correct colour.
double bias(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate);

class Rows {
 public:
    explicit Rows(std::vector<Claim>& claims) : claims_(claims) {}

    template <class Find>
    void add(const char* id, const char* place, const char* claim, const Printed& printed, const Rule& rule,
             Find find) {
        claims_.push_back({id, "Enderton et al. 2011", place, claim, printed, rule, Basis::kDefinition,
                           "enumeration in double precision", false, [find](ClaimRuns&) { return find(); }});
    }
    // Printed numbers of one estimate.
    template <class Find>
    void add_digits(const char* id, const char* place, const char* claim, const char* printed, Find find) {
        add(id, place, claim, Printed::numbers_of(printed), rule::digits(), find);
    }

 private:
    std::vector<Claim>& claims_;
};

}  // namespace ropsim::stochastic_claims
