#include "model/tile_sample_report.h"

#include "model/tile_sample_cycles.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {

namespace {

double relative_variance(const Estimate& e) {
    const double half = (e.high - e.low) / 2 / student_t_975(1e6);
    return e.value != 0 ? half * half / (e.value * e.value) : 0;
}

Estimate scaled(const Estimate& e, double by) {
    return {e.value * by, e.low * by, e.high * by};
}

// Of quantities of the same squares, which err together.
Estimate sum_of(const std::vector<Estimate>& parts) {
    Estimate sum;
    for (const Estimate& e : parts) sum = {sum.value + e.value, sum.low + e.low, sum.high + e.high};
    return sum;
}

constexpr std::array<const char*, 4> kTouched{"/worst_case_read_bytes", "/worst_case_write_bytes",
                                              "/read_bytes", "/write_bytes"};

}  // namespace

SampleReport::SampleReport(const Frame& frame, const SampleSquares& squares,
                           const std::vector<std::unique_ptr<SampleStream>>& streams, TileSample& sample)
    : frame_(frame), squares_(squares), streams_(streams), sample_(sample) {
    for (const auto& stream : streams_) {
        const SampleRow row = stream->total();
        total_.resize(row.size());
        for (std::size_t c = 0; c < row.size(); ++c) total_[c] += row[c];
    }
}

Estimate SampleReport::column(std::size_t c) const {
    std::vector<double> values(squares_.size());
    for (const auto& stream : streams_)
        for (std::size_t s = 0; s < values.size(); ++s)
            if (!stream->rows()[s].empty()) values[s] += stream->rows()[s][c];
    return squares_.total(values);
}

void SampleReport::put(const std::string& place, const Estimate& e) {
    Estimate positive = e;
    positive.low = std::max(0.0, e.low);
    sample_.estimates.emplace_back(place, positive);
}

std::string SampleReport::place_of(std::size_t surface) const {
    return "/traffic/" + frame_.surfaces().name(static_cast<int>(surface));
}

void SampleReport::add_counts() {
    const FragmentCounts& n = frame_.fragments();
    const auto put_count = [&](const char* name, std::uint64_t counted) {
        put(std::string("/fragments/") + name, squares_.total_of_count(static_cast<double>(counted)));
    };
    put_count("depth_culled", n.depth_culled);
    put_count("zero_alpha", n.zero_alpha);
    put_count("joined", n.joined);
    put_count("operated", n.operated);
    const Estimate resolved = column(kResolved);
    const double counted = std::max(1.0, total_[kResolved]);
    for (std::size_t p = 0; p < frame_.cost().size(); ++p) {
        if (frame_.cost()[p].name.empty()) continue;
        const auto count = static_cast<double>(frame_.path_count(p));
        put("/operation/" + frame_.cost()[p].name + "/count",
            frame_.cost()[p].pass == kResolvePass && total_[kResolved] > 0 ? scaled(resolved, count / counted)
                                                                           : squares_.total_of_count(count));
    }
}

void SampleReport::add_touched() {
    const std::vector<SurfaceTraffic> traffic = frame_.traffic();
    const Estimate operated = column(kPixels);
    const Estimate drawn = total_[kPixels] > 0 ? scaled(operated, 1 / total_[kPixels]) : Estimate{};
    std::array<std::vector<Estimate>, 4> all;
    for (std::size_t s = 0; s < traffic.size(); ++s) {
        const SurfaceTraffic& t = traffic[s];
        const std::array<std::uint64_t, 4> bytes{t.worst_read, t.worst_write, t.read, t.write};
        if (t.worst_read + t.worst_write + t.read + t.write == 0) continue;
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t c = kBySurface + 4 * s + 2 + k % 2;
            const Estimate per = total_[c] > 0 ? scaled(column(c), 1 / total_[c]) : drawn;
            const Estimate e = scaled(per, static_cast<double>(bytes[k]));
            all[k].push_back(e);
            put(place_of(s) + kTouched[k], e);
        }
    }
    for (std::size_t k = 0; k < 4; ++k) put(std::string("/traffic/total") + kTouched[k], sum_of(all[k]));
    const Estimate bytes = sum_of({sum_of(all[2]), sum_of(all[3])});
    const auto& header_pixels = static_cast<double>(frame_.width()) * frame_.height();
    if (squares_.all_fragments() > 0) put("/bytes_per_fragment", scaled(bytes, 1 / squares_.all_fragments()));
    put("/bits_per_pixel_write", scaled(sum_of(all[3]), 8 / header_pixels));
}

void SampleReport::add_pins() {
    for (int s = 0; s < frame_.surfaces().surfaces(); ++s) {
        const auto surface = static_cast<std::size_t>(s);
        const std::size_t c = kBySurface + 4 * surface;
        double touched = 0;
        for (std::size_t k = 0; k < 4; ++k) touched += total_[c + k];
        if (touched == 0) continue;
        put(place_of(surface) + "/pin_read_bytes", column(c));
        put(place_of(surface) + "/pin_write_bytes", column(c + 1));
    }
    const Estimate read = column(kPinReads);
    const Estimate write = column(kPinWrites);
    put("/traffic/total/pin_read_bytes", read);
    put("/traffic/total/pin_write_bytes", write);
    put("/dram/read_bytes", read);
    put("/dram/write_bytes", write);
    put("/rop_cache/hits", column(kHits));
    put("/rop_cache/misses", column(kMisses));
    put("/rop_cache/line_allocations", column(kAllocations));
    put("/rop_cache/line_evictions", column(kEvictions));
    put("/rop_cache/sectors_written_back", column(kSectorsWritten));
    put("/rop_cache/bytes_written_back", column(kBytesWritten));
    put("/rop_cache/fills_avoided_by_fast_clear", column(kFillsAvoided));
}

// Reads and writes of a square vary together: estimated as one sum.
Estimate SampleReport::pin_bytes() const {
    std::vector<double> values(squares_.size());
    for (const auto& stream : streams_)
        for (std::size_t s = 0; s < values.size(); ++s)
            if (!stream->rows()[s].empty())
                values[s] += stream->rows()[s][kPinReads] + stream->rows()[s][kPinWrites];
    return squares_.total(values);
}

Estimate SampleReport::ratio(const std::vector<double>& of, const std::vector<double>& to,
                             const Estimate& by) {
    double sum_of_all = 0, sum_to = 0, squares = 0;
    for (std::size_t i = 0; i < of.size(); ++i) {
        sum_of_all += of[i];
        sum_to += to[i];
    }
    if (sum_to == 0) return {};
    const double r = sum_of_all / sum_to;
    for (std::size_t i = 0; i < of.size(); ++i) squares += (of[i] - r * to[i]) * (of[i] - r * to[i]);
    const auto n = static_cast<double>(of.size());
    const double own = n > 1 && r > 0 ? squares * n / (n - 1) / (sum_of_all * sum_of_all) : 0;
    const double value = r * by.value;
    return Estimate::with_variance(value, value * value * (own + relative_variance(by)), n);
}

void SampleReport::add_timing(const SampledTiming& timing, const MachineConfig& config,
                              double front_end_cycles) {
    const CycleEstimate cycles = estimate_cycles(streams_, timing, squares_, sample_.plan, front_end_cycles);
    put("/cycles", cycles.frame);
    put("/seconds", scaled(cycles.frame, static_cast<double>(config.rop_period_ps) * 1e-12));
    const Estimate bytes = pin_bytes();
    add_rates(bytes, cycles.frame, config);
    add_stretches(timing, bytes, cycles.frame, cycles.mean);
}

void SampleReport::add_rates(const Estimate& bytes, const Estimate& cycles, const MachineConfig& config) {
    const double period = static_cast<double>(config.rop_period_ps) * 1e-12;
    const double bytes_a_cycle_at_peak = config.dram.peak_bytes_per_second() * period * config.partitions;
    const double value = bytes.value / cycles.value;
    const double variance = relative_variance(bytes) + relative_variance(cycles);
    const Estimate rate = Estimate::with_variance(value, value * value * variance, 1e6);
    put("/dram/bytes_per_second", scaled(rate, 1 / period));
    put("/dram/utilisation", scaled(rate, 1 / bytes_a_cycle_at_peak));
}

// Rows of the channels by byte, and labels of the stages by cycle.
void SampleReport::add_stretches(const SampledTiming& timing, const Estimate& bytes, const Estimate& frame,
                                 const Estimate& mean) {
    const double partitions = squares_.partitions();
    std::vector<double> took, moved;
    std::array<std::array<std::vector<double>, kStageLabels>, 2> labels;
    std::array<std::vector<double>, 3> rows;
    for (std::size_t i = 0; i < streams_.size(); ++i) {
        for (std::size_t k = 0; k < timing.stretches[i].size(); ++k) {
            const TimedStretch& t = timing.stretches[i][k];
            const SampleRow& counted = streams_[i]->stretches()[k].measured;
            const SampleRow row = counted.empty() ? streams_[i]->total() : counted;
            took.push_back(static_cast<double>(t.cycles));
            moved.push_back(row[kPinReads] + row[kPinWrites]);
            for (std::size_t a = 0; a < labels.size(); ++a)
                for (std::size_t l = 0; l < t.labels[a].size(); ++l)
                    labels[a][l].push_back(static_cast<double>(t.labels[a][l]));
            for (std::size_t r = 0; r < rows.size(); ++r) rows[r].push_back(static_cast<double>(t.rows[r]));
        }
    }
    for (std::size_t r = 0; r < rows.size(); ++r)
        put(std::array{"/dram/row_hits", "/dram/row_misses", "/dram/row_conflicts"}[r],
            ratio(rows[r], moved, bytes));
    // A partition that is done earlier than the slowest is idle meanwhile.
    const Estimate all = scaled(mean, partitions);
    const Estimate end = scaled(frame, partitions);
    for (std::size_t a = 0; a < labels.size(); ++a) {
        const std::string stage = a == 0 ? "/stages/rop_tag" : "/stages/rop_operation";
        sample_.estimates.emplace_back(stage + "/instances", Estimate{partitions, partitions, partitions});
        double others = 0;
        for (std::size_t l = 0; l < labels[a].size(); ++l) {
            if (static_cast<StageLabel>(l) == StageLabel::kIdle) continue;
            const Estimate e = ratio(labels[a][l], took, all);
            if (e.value == 0 && l != 0) continue;
            others += e.value;
            put(fmt::format("{}/{}{}", stage, l == 0 ? "" : "stall/", kStageLabelNames[l]), e);
        }
        put(stage + "/idle", {end.value - others, end.low - others, end.high - others});
    }
}

}  // namespace ropsim
