// Combinations of keys that make no sense are refused with the key at fault and a way out.
#include "base/error.h"
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::TestFrame;

struct Refused {
    const char* technique;
    int spatial_samples;
    const char* key;      // named as the place
    const char* way_out;  // part of the message
};

constexpr Refused kRefused[] = {
    {"stochastic:samples=6", 4, "samples", "multiple of 4"},
    {"stochastic:samples=16,hardware_samples=6", 1, "hardware_samples", "must divide"},
    {"stochastic:correction=accumulated", 1, "correction", "correction=coverage"},
    {"stochastic:accumulator=sample", 1, "accumulator", "method=depth_based"},
    {"stochastic:passes=merged", 1, "passes", "correction=none"},
    {"stochastic:samples=16,hardware_samples=8,correction=coverage,passes=merged", 1, "passes", "one round"},
    {"stochastic:method=depth_based,filter=gaussian", 1, "filter", "accumulator=sample"},
    {"stochastic:correction=coverage,filter=gaussian", 1, "filter", "total_alpha=sample"},
    {"stochastic:adaptive_error=1", 1, "adaptive_error", "hardware_samples"},
    {"stochastic:samples=64,hardware_samples=8,method=depth_based,correction=none,adaptive_error=1", 1,
     "adaptive_error", "correction=accumulated"},
    {"stochastic:cross_filter=2", 1, "cross_filter", "method=depth_based"},
    {"stochastic:masks=coin,rounding=dither", 1, "rounding", "masks=choose"},
    {"stochastic:masks=run,depth_test=first", 1, "depth_test", "masks=choose"},
    {"stochastic:seed_from=pattern", 1, "seed_from", "masks=table"},
    {"stochastic:masks=blue_noise,seed_from=depth", 1, "seed_from", "object"},
    {"stochastic:bright_samples=16", 1, "bright_samples", "at most samples=8"},
    {"laine_karras:compaction=false,sort=true", 1, "sort", "sort=false"},
};

TEST(SamplingOptions, WhatMakesNoSenseIsRefused) {
    for (const Refused& r : kRefused) {
        try {
            TestFrame::make(r.technique, test::header_of(4, 4, r.spatial_samples));
            ADD_FAILURE() << r.technique << " is taken";
        } catch (const UserError& error) {
            EXPECT_NE(error.where().find(r.key), std::string::npos) << error.where();
            EXPECT_NE(std::string(error.what()).find(r.way_out), std::string::npos) << error.what();
        }
    }
}

}  // namespace
}  // namespace ropsim
