// What a sample's streams counted, as estimates at their places in run.json.
#pragma once

#include "model/tile_sample.h"
#include "model/tile_sample_machine.h"
#include "model/tile_sample_squares.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace ropsim {

class SampleReport {
 public:
    // After the end of the frame; all must outlive it.
    SampleReport(const Frame& frame, const SampleSquares& squares,
                 const std::vector<std::unique_ptr<SampleStream>>& streams, TileSample& sample);

    // Of a column, over the whole frame.
    Estimate column(std::size_t c) const;
    void add_counts();   // of fragments and control paths
    void add_touched();  // bytes without caches
    void add_pins();     // bytes on the pins, and what the caches did
    void add_timing(const SampledTiming& timing, const MachineConfig& config, double front_end_cycles);

 private:
    void put(const std::string& place, const Estimate& e);
    std::string place_of(std::size_t surface) const;
    Estimate pin_bytes() const;
    // `of` per `to` in the stretches, times `by`.
    static Estimate ratio(const std::vector<double>& of, const std::vector<double>& to, const Estimate& by);
    void add_rates(const Estimate& bytes, const Estimate& cycles, const MachineConfig& config);
    void add_stretches(const SampledTiming& timing, const Estimate& bytes, const Estimate& frame,
                       const Estimate& mean);

    const Frame& frame_;
    const SampleSquares& squares_;
    const std::vector<std::unique_ptr<SampleStream>>& streams_;
    TileSample& sample_;
    SampleRow total_;
};

}  // namespace ropsim
