// What a trace is like: depth complexity, alpha, channels, and what the opaque layer hides.
#include "traces/trace_statistics.h"

#include "traces/sample_positions.h"
#include "traces/value_ranges.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace ropsim {

namespace {

DepthComplexity depth_complexity(const std::vector<std::uint32_t>& layers) {
    DepthComplexity result;
    result.max = *std::max_element(layers.begin(), layers.end());
    result.histogram.resize(result.max + 1);
    std::uint64_t fragments = 0;
    for (const std::uint32_t count : layers) {
        ++result.histogram[count];
        fragments += count;
    }
    result.covered_pixels = layers.size() - result.histogram[0];
    if (result.covered_pixels != 0)
        result.mean = static_cast<double>(fragments) / static_cast<double>(result.covered_pixels);
    return result;
}

// Collects what is unusual about one fragment's values.
struct Oddity {
    bool nan = false, infinite = false, out_of_range = false;
    void see(float value, bool is_share) {
        nan = nan || std::isnan(value);
        infinite = infinite || std::isinf(value);
        out_of_range = out_of_range || (is_share && std::isfinite(value) && !(value >= 0 && value <= 1));
    }
};

class Measurer {
 public:
    Measurer(const TraceHeader& header, PixelLayers& layers)
        : header_(header), layers_(layers), positions_(sample_positions(header.samples)) {
        const auto pixels = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height);
        layers.all.assign(pixels, 0);
        layers.visible.assign(pixels, 0);
        result_.draw_fragments.resize(header.draws.size());
        if (header.non_finite) result_.unusual.emplace();
        if (header.depth_slopes) result_.slopes.emplace();
        if (header.materials) result_.materials.emplace();
    }

    void take(FragmentChunk& chunk) {
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            Fragment& f = chunk.fragments[i];
            DepthSlope slope = header_.depth_slopes ? chunk.slopes[i] : DepthSlope{};
            Material material = header_.materials ? chunk.materials[i] : Material{};
            if (header_.non_finite) {
                count_unusual(f, slope, material);
                bring_into_range(f);
                bring_into_range(slope);
                bring_into_range(material);
            }
            count(f, slope);
            if (header_.depth_slopes) count_slope(slope);
            if (header_.materials) count_material(material);
        }
        result_.fragments += chunk.size();
    }

    TraceStatistics finish() {
        if (result_.fragments != 0) result_.alpha_mean = alpha_sum_ / static_cast<double>(result_.fragments);
        result_.all = depth_complexity(layers_.all);
        result_.visible = depth_complexity(layers_.visible);
        return std::move(result_);
    }

 private:
    // GL_LESS at each covered sample.
    bool passes_somewhere(const Fragment& f, const DepthSlope& slope, std::size_t pixel) const {
        if (!header_.opaque || !header_.draws[f.draw].depth_test) return true;
        const float* const depth = &header_.opaque->depth[pixel * positions_.size()];
        for (unsigned left = f.coverage; left != 0; left &= left - 1) {
            const auto m = static_cast<std::size_t>(std::countr_zero(left));
            const float z = f.z + slope.dx * positions_[m].x() + slope.dy * positions_[m].y();
            if (std::clamp(z, 0.0f, 1.0f) < depth[m]) return true;
        }
        return false;
    }

    void count(const Fragment& f, const DepthSlope& slope) {
        const std::size_t pixel = f.y * static_cast<std::size_t>(header_.width) + f.x;
        const bool passes = passes_somewhere(f, slope, pixel);
        ++layers_.all[pixel];
        layers_.visible[pixel] += passes && f.coverage != 0 ? 1 : 0;
        result_.hidden_by_opaque += !passes && f.coverage != 0 ? 1 : 0;
        ++result_.draw_fragments[f.draw];
        ++result_.alpha_histogram[std::min<std::size_t>(9, static_cast<std::size_t>(f.a * 10.0f))];
        result_.zero_alpha += f.a == 0.0f ? 1 : 0;
        result_.full_alpha += f.a == 1.0f ? 1 : 0;
        result_.facing_back += faces_back(f) ? 1 : 0;
        alpha_sum_ += static_cast<double>(f.a);
    }

    void count_unusual(const Fragment& f, const DepthSlope& slope, const Material& m) {
        Oddity odd;
        odd.see(f.z, true);
        odd.see(f.a, true);
        for (const float value :
             {f.r, f.g, f.b, slope.dx, slope.dy, m.eta, m.normal[0], m.normal[1], m.normal[2]})
            odd.see(value, false);
        for (const float value : {m.transmission[0], m.transmission[1], m.transmission[2], m.collimation})
            odd.see(value, true);
        result_.unusual->with_nan += odd.nan ? 1 : 0;
        result_.unusual->with_infinity += odd.infinite ? 1 : 0;
        result_.unusual->out_of_range += odd.out_of_range ? 1 : 0;
    }

    void count_slope(const DepthSlope& slope) {
        result_.slopes->sloped += slope.dx != 0 || slope.dy != 0 ? 1 : 0;
        result_.slopes->steepest =
            std::max({result_.slopes->steepest, std::abs(slope.dx), std::abs(slope.dy)});
    }

    void count_material(const Material& m) {
        MaterialStatistics& s = *result_.materials;
        s.transmissive += m.transmission[0] > 0 || m.transmission[1] > 0 || m.transmission[2] > 0 ? 1 : 0;
        s.scattering += m.collimation < 1 ? 1 : 0;
        s.refractive += m.eta != 1 ? 1 : 0;
    }

    const TraceHeader& header_;
    PixelLayers& layers_;
    std::span<const SamplePosition> positions_;
    TraceStatistics result_;
    double alpha_sum_ = 0;
};

}  // namespace

TraceStatistics measure_trace(TraceReader& reader, PixelLayers* layers) {
    PixelLayers own;
    Measurer measurer(reader.header(), layers != nullptr ? *layers : own);
    FragmentChunk chunk;
    reader.rewind();
    while (reader.next_raw(chunk)) measurer.take(chunk);
    reader.rewind();
    return measurer.finish();
}

}  // namespace ropsim
