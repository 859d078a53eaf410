// The march: tiles are made in parallel, a piece of them at a time, and written in order.
#include "analysis/volume_trace.h"

#include "analysis/volume_cost.h"
#include "analysis/volume_light.h"
#include "analysis/volume_ray.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace ropsim {
namespace {

constexpr double kDefaultLight = 3;       // a white matte surface across its rays then reflects about 1
constexpr double kBrightest = 65504;      // the largest half
constexpr double kLongest = 1e9;          // metres, and the most extinction a metre
constexpr int kPieceFragments = 1 << 20;  // made before they are written
constexpr int kMostTiles = 4096;
constexpr const char* kVolumeDraw = "volume";

void check_range(const char* option, double value, double low, double high) {
    if (!(value >= low && value <= high))
        throw UserError(option, fmt::format("{} is outside {} to {}", value, low, high));
}

void check_colour(const char* option, const glm::dvec3& color, double high) {
    for (int c = 0; c < 3; ++c) check_range(option, color[c], 0, high);
}

void check_options(const VolumeOptions& o) {
    const VolumeMedium& m = o.medium;
    check_range("--extinction", m.extinction, 0, kLongest);
    check_colour("--albedo", m.albedo, 1);
    if (!(m.anisotropy > -1 && m.anisotropy < 1))
        throw UserError("--anisotropy",
                        fmt::format("{} is not between -1 and 1, both excluded: there all light "
                                    "would keep its line",
                                    m.anisotropy));
    if (m.height_falloff && !(*m.height_falloff > 0 && *m.height_falloff <= kLongest))
        throw UserError("--height-falloff",
                        fmt::format("{} is not a height above 0 m; leave it out for a uniform medium",
                                    *m.height_falloff));
    check_range("--base-height", m.base_height, -kLongest, kLongest);
    check_range("--collimation", m.collimation, 0, 1);
    check_range("--steps", o.steps, 1, kMaxVolumeSteps);
    check_range("--near", o.near, 0, kLongest);
    if (o.far && !(*o.far > o.near && *o.far <= kLongest))
        throw UserError("--far", fmt::format("{} m is not beyond --near, {} m", *o.far, o.near));
    check_colour("--ambient", o.ambient, kBrightest);
    if (o.light) check_colour("--light", *o.light, kBrightest);
    if (!o.shadows.empty() && o.light == glm::dvec3(0))
        throw UserError("--shadows", "nothing can dim a --light of 0; leave one of them out");
    if (o.filter < 1 || o.filter > ShadowFilter::kMaxSide || o.filter % 2 == 0)
        throw UserError("--filter", fmt::format("{} is not an odd number of texels from 1 to {}", o.filter,
                                                ShadowFilter::kMaxSide));
}

class Volume {
 public:
    Volume(const std::string& in, const VolumeOptions& options)
        : options_(options), reader_(in), header_(reader_.header()) {
        check_options(options);
        check_trace();
        rays_.emplace(header_);
        if (!rays_->valid())
            throw UserError(in,
                            "its camera's matrices cannot be inverted or do not look along -z; give the "
                            "trace a proper camera");
        place_light();
        last_ = header_;
        last_.materials = true;
        if (options.color) last_.color_storage = *options.color;
        summary_.draw = make_draw();
        last_.draws.push_back(summary_.draw);
    }

    VolumeSummary run(const std::string& out) {
        TraceWriter writer(out, last_);
        copy(writer);
        const int tiles = tiles_across(header_.width) * tiles_across(header_.height);
        const int piece = std::clamp(kPieceFragments / (kTilePixels * options_.steps), 1, kMostTiles);
        std::vector<FragmentChunk> made(static_cast<std::size_t>(piece));
        std::vector<std::uint64_t> pixels(made.size());
        for (int first = 0; first < tiles; first += piece) {
            const int count = std::min(piece, tiles - first);
            parallel_for(options_.threads, count, [&](int i) {
                const auto at = static_cast<std::size_t>(i);
                made[at].clear();
                pixels[at] = march_tile(first + i, made[at]);
            });
            for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
                summary_.pixels += pixels[i];
                summary_.fragments += made[i].size();
                writer.append(made[i]);
            }
        }
        writer.finish();
        return summary_;
    }

 private:
    void check_trace() const {
        if (!header_.camera)
            throw UserError(reader_.path(),
                            "has no camera, so that no ray can be marched; capture the scene, "
                            "or give the trace a camera");
        if (header_.draws.size() > std::numeric_limits<std::uint16_t>::max())
            throw UserError(reader_.path(),
                            "has as many draws as a trace can hold; cut some with 'trace cut --draws'");
        for (const Draw& draw : header_.draws)
            if (draw.name == kVolumeDraw)
                throw UserError(reader_.path(),
                                fmt::format("has a draw '{}' already, and a second medium would only add to "
                                            "it; fill the trace that it was made from",
                                            kVolumeDraw));
        const bool needs_light = options_.light || !options_.shadows.empty();
        if (needs_light && !header_.light)
            throw UserError(reader_.path(),
                            "has no light; leave out --light and --shadows, or capture a scene "
                            "that has one");
    }

    void place_light() {
        const glm::dvec3 irradiance = options_.light.value_or(glm::dvec3(kDefaultLight));
        if (!header_.light || irradiance == glm::dvec3(0)) return;
        light_.emplace(*header_.light, static_cast<double>(header_.camera->metres_per_unit));
        irradiance_ = irradiance;
        if (!options_.shadows.empty())
            light_->cast_shadows(options_.shadows, reader_, options_.filter, options_.threads);
    }

    Draw make_draw() const {
        Draw draw;
        draw.name = kVolumeDraw;
        for (const Draw& other : header_.draws)
            draw.object_id = std::max(draw.object_id, other.object_id + 1);
        draw.depth_test = false;  // the march reads the opaque depth itself
        VolumeShader shader;
        shader.falloff = options_.medium.height_falloff.has_value();
        shader.light = light_.has_value();
        shader.point_light = light_ && !light_->far_away();
        shader.shadow_texels = options_.shadows.empty() ? 0 : options_.filter;
        shader.jitter = options_.jitter;
        shader.steps = options_.steps;
        VolumeCost cost = measure_volume_cost(shader);
        draw.full = cost.full;
        draw.alpha = cost.alpha;
        draw.cost_source = std::move(cost.source);
        return draw;
    }

    void copy(TraceWriter& writer) {
        FragmentChunk chunk;
        while (reader_.next_raw(chunk)) {
            chunk.materials.resize(chunk.size());  // the default of a trace that has none
            writer.append(chunk);
        }
    }

    // The number of its pixels with fragments.
    std::uint64_t march_tile(int tile, FragmentChunk& out) const {
        const int across = tiles_across(header_.width);
        std::uint64_t pixels = 0;
        for (int i = 0; i < kTilePixels; ++i) {
            // Bits of i from the lowest: x and y in the quad, then the quad in its row and column.
            const int x = tile % across * kTileSize + (i >> 2) % 4 * 2 + (i & 1);
            const int y = tile / across * kTileSize + (i >> 4) * 2 + (i >> 1 & 1);
            if (x >= header_.width || y >= header_.height) continue;
            const std::size_t before = out.size();
            march(x, y, out);
            pixels += out.size() > before ? 1 : 0;
        }
        if (header_.depth_slopes) out.slopes.assign(out.size(), DepthSlope{});
        return pixels;
    }

    // Where a pixel's march ends: the opaque layer, the end that was asked for, the far plane.
    double end(const PixelRay& ray, std::span<const float> opaque, int x, int y) const {
        double far = ray.distance(1);
        if (options_.far) far = std::min(far, *options_.far);
        float depth = 0;
        for (const float z : opaque) depth = std::max(depth, z);
        if (!opaque.empty() && std::isfinite(depth))
            far = std::min(far, ray.distance(static_cast<double>(depth)));
        if (!std::isfinite(far))
            throw UserError(reader_.path(),
                            fmt::format("shows nothing opaque at pixel {},{} and its camera has "
                                        "no far plane; say with --far where the medium ends",
                                        x, y));
        return far;
    }

    void march(int x, int y, FragmentChunk& out) const {
        const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(header_.width) +
                           static_cast<std::size_t>(x);
        const auto samples = static_cast<std::size_t>(header_.samples);
        std::span<const float> opaque;
        if (header_.opaque) opaque = std::span(header_.opaque->depth).subspan(pixel * samples, samples);
        const PixelRay ray = (*rays_)(x, y);
        const double near = std::max(options_.near, ray.distance(0));
        const double length = (end(ray, opaque, x, y) - near) / options_.steps;
        if (!(length > 0)) return;
        const double place = options_.jitter
                                 ? static_cast<double>(random_unit(
                                       mix64(mix64(options_.seed) + static_cast<std::uint64_t>(pixel)), 0))
                                 : 0.5;
        const bool parallel = light_ && light_->far_away();
        const double phase = parallel ? phase_at(ray, {}) : 0;
        for (int i = 0; i < options_.steps; ++i) {
            const double distance = near + (i + place) * length;
            const glm::dvec3 at = ray.at(distance);
            const double height = at.y * static_cast<double>(header_.camera->metres_per_unit);
            const double share = absorbed_share(extinction_at(options_.medium, height) * length);
            const auto alpha = static_cast<float>(share);
            if (!(alpha > 0)) continue;
            Fragment f{};
            f.z = static_cast<float>(std::clamp(ray.depth(distance), 0.0, 1.0));
            f.coverage = coverage(f.z, opaque);
            if (f.coverage == 0) continue;
            glm::dvec3 source = options_.ambient;
            if (light_)
                source += irradiance_ * light_->falloff(at) * (parallel ? phase : phase_at(ray, at)) *
                          light_->visibility({x + 0.5, y + 0.5, static_cast<double>(f.z)});
            const glm::dvec3 color = options_.medium.albedo * source * share;
            f.r = static_cast<float>(color.r);
            f.g = static_cast<float>(color.g);
            f.b = static_cast<float>(color.b);
            f.a = alpha;
            f.x = static_cast<std::uint16_t>(x);
            f.y = static_cast<std::uint16_t>(y);
            f.draw = static_cast<std::uint16_t>(header_.draws.size());
            out.fragments.push_back(f);
            out.materials.push_back(material(ray));
        }
    }

    double phase_at(const PixelRay& ray, const glm::dvec3& at) const {
        const double cosine = -glm::dot(light_->direction(at), glm::normalize(ray.direction));
        return henyey_greenstein(cosine, options_.medium.anisotropy);
    }

    // Samples in front of whose opaque depth a step lies. The farthest has it in front, whatever rounding
    // did to the depth of the last step.
    std::uint16_t coverage(float& z, std::span<const float> opaque) const {
        const auto all = static_cast<std::uint16_t>((1u << header_.samples) - 1u);
        if (opaque.empty()) return all;
        z = std::min(z, std::nextafter(*std::max_element(opaque.begin(), opaque.end()), 0.0f));
        unsigned covered = 0;
        for (std::size_t m = 0; m < opaque.size(); ++m) covered |= z < opaque[m] ? 1u << m : 0u;
        return static_cast<std::uint16_t>(covered);
    }

    Material material(const PixelRay& ray) const {
        Material m;
        m.collimation = static_cast<float>(options_.medium.collimation);
        for (int c = 0; c < 3; ++c) m.normal[c] = static_cast<float>(ray.to_eye[c]);
        return m;
    }

    VolumeOptions options_;
    TraceReader reader_;
    const TraceHeader& header_;
    TraceHeader last_;  // of the new trace
    std::optional<PixelRays> rays_;
    std::optional<VolumeLight> light_;
    glm::dvec3 irradiance_{0};
    VolumeSummary summary_;
};

}  // namespace

VolumeSummary add_volume(const std::string& trace_path, const std::string& out_path,
                         const VolumeOptions& options) {
    return Volume(trace_path, options).run(out_path);
}

}  // namespace ropsim
