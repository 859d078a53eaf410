// What the tests of rop/ share: random fragments made in memory, a frame to run operations on, datapath
// shapes, and an exact compositor in double precision that knows nothing of the techniques.
#pragma once

#include "rop/operation.h"
#include "rop/pass_sequence.h"
#include "rop/registry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace ropsim::test {

// The standard's generator and own scaling: the same numbers everywhere, and nothing of base/random.h.
class Random {
 public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
    float real(double low, double high) { return static_cast<float>(low + (high - low) * unit()); }
    int integer(int low, int high) { return low + static_cast<int>(unit() * (high - low + 1)); }
    template <class T>
    void shuffle(std::vector<T>& values) {
        for (std::size_t i = values.size(); i > 1; --i)
            std::swap(values[i - 1], values[static_cast<std::size_t>(integer(0, static_cast<int>(i) - 1))]);
    }

 private:
    std::mt19937_64 engine_;
};

inline TraceHeader header_of(int width, int height, int samples = 1,
                             glm::vec3 background = {0.25f, 0.5f, 0.125f}) {
    TraceHeader header;
    header.width = width;
    header.height = height;
    header.samples = samples;
    header.background = background;
    return header;
}

// An opaque layer with a third of its pixels empty, the rest at depths in [0.4, 1); alike in all samples of a
// pixel.
inline TraceHeader opaque_header(int width, int height, int samples, Random& random) {
    TraceHeader header = header_of(width, height, samples);
    OpaqueLayer layer;
    for (int i = 0; i < width * height; ++i) {
        std::array<float, 3> color{};
        for (float& c : color) c = random.real(0, 1);
        const float depth = i % 3 == 0 ? std::numeric_limits<float>::infinity() : random.real(0.4, 1);
        for (int m = 0; m < samples; ++m) {
            layer.rgb.insert(layer.rgb.end(), color.begin(), color.end());
            layer.depth.push_back(depth);
        }
    }
    header.opaque = std::move(layer);
    return header;
}

inline float opaque_depth(const TraceHeader& header, int x, int y) {
    if (!header.opaque) return std::numeric_limits<float>::infinity();
    return header.opaque->depth[static_cast<std::size_t>((y * header.width + x) * header.samples)];
}

inline std::array<double, 3> background_of(const TraceHeader& header, int x, int y) {
    if (!header.opaque) return {header.background.r, header.background.g, header.background.b};
    const float* rgb =
        &header.opaque->rgb[static_cast<std::size_t>(3 * (y * header.width + x) * header.samples)];
    return {rgb[0], rgb[1], rgb[2]};
}

struct FragmentOptions {
    std::size_t count = 10000;
    bool distinct_depths = false;  // else about one in four shares its depth with others
    bool extremes = true;          // some alphas of exactly 0 and 1
    int most_in_a_pixel = 1 << 30;
};

// Fragments that passed the depth test against the header's opaque layer, in random order of depth.
inline std::vector<Fragment> random_fragments(const TraceHeader& header, const FragmentOptions& options,
                                              Random& random) {
    std::vector<Fragment> fragments;
    std::vector<int> layers(static_cast<std::size_t>(header.width * header.height), 0);
    std::map<std::pair<int, float>, bool> taken;
    const int all = (1 << header.samples) - 1;
    for (std::uint32_t primitive = 0; fragments.size() < options.count; ++primitive) {
        Fragment f{};
        f.x = static_cast<std::uint16_t>(random.integer(0, header.width - 1));
        f.y = static_cast<std::uint16_t>(random.integer(0, header.height - 1));
        f.z = random.real(0.001, 0.999);
        if (!options.distinct_depths && random.integer(0, 3) == 0) f.z = std::round(f.z * 16) / 17;
        f.a = random.real(0.01, 1);
        if (options.extremes && random.integer(0, 15) == 0) f.a = static_cast<float>(random.integer(0, 1));
        f.r = random.real(0, 1) * f.a;
        f.g = random.real(0, 1) * f.a;
        f.b = random.real(0, 1) * f.a;
        f.primitive = primitive;
        f.draw = static_cast<std::uint16_t>(random.integer(0, 3));
        f.coverage = static_cast<std::uint16_t>(random.integer(0, 1) == 0 ? all : random.integer(1, all));
        const int pixel = f.y * header.width + f.x;
        if (!(f.z < opaque_depth(header, f.x, f.y))) continue;
        if (options.distinct_depths && !taken.emplace(std::pair(pixel, f.z), true).second) continue;
        if (layers[static_cast<std::size_t>(pixel)] == options.most_in_a_pixel) continue;
        ++layers[static_cast<std::size_t>(pixel)];
        fragments.push_back(f);
    }
    return fragments;
}

// The fragments as a pass of that resolution has them: somewhere in its smaller image.
inline std::vector<Fragment> at_resolution(std::span<const Fragment> fragments, const TraceHeader& header,
                                           int scale) {
    std::vector<Fragment> drawn(fragments.begin(), fragments.end());
    const int last_x = std::max(low_resolution(header.width, scale), 1) - 1;
    const int last_y = std::max(low_resolution(header.height, scale), 1) - 1;
    for (Fragment& f : drawn) {
        f.x = static_cast<std::uint16_t>(std::min(f.x / scale, last_x));
        f.y = static_cast<std::uint16_t>(std::min(f.y / scale, last_y));
    }
    return drawn;
}

// A camera one metre high at one metre, near 0.1 and far 100, and the word that fragments have materials.
inline TraceHeader with_materials(TraceHeader header) {
    header.materials = true;
    Camera camera;
    camera.near_plane = 0.1f;
    camera.far_plane = 100;
    camera.fovy_degrees = 53.130102f;
    const float aspect = static_cast<float>(header.width) / static_cast<float>(header.height);
    camera.projection = glm::mat4(0.0f);
    camera.projection[0][0] = 2 / aspect;
    camera.projection[1][1] = 2;
    camera.projection[2][2] = -(100.0f + 0.1f) / (100.0f - 0.1f);
    camera.projection[2][3] = -1;
    camera.projection[3][2] = -2 * 100.0f * 0.1f / (100.0f - 0.1f);
    header.camera = camera;
    return header;
}
// Half of them the default, the others glass, frosted or fog, looking anywhere towards the eye.
inline std::vector<Material> random_materials(std::size_t count, Random& random) {
    std::vector<Material> materials(count);
    for (Material& m : materials) {
        if (random.integer(0, 1) == 0) continue;
        for (float& t : m.transmission) t = random.real(0, 1);
        if (random.integer(0, 1) == 0) m.collimation = random.real(0, 1);
        if (random.integer(0, 1) == 0) m.eta = random.real(1, 2);
        glm::vec3 normal(random.real(-0.7, 0.7), random.real(-0.7, 0.7), 1.0f);
        normal = glm::normalize(normal);
        for (int c = 0; c < 3; ++c) m.normal[c] = normal[c];
    }
    return materials;
}

// One fragment covering everything, of a straight colour.
inline Fragment fragment_at(int x, int y, float z, float a, std::array<float, 3> rgb,
                            std::uint32_t primitive = 0) {
    return {z,
            rgb[0] * a,
            rgb[1] * a,
            rgb[2] * a,
            a,
            static_cast<std::uint16_t>(x),
            static_cast<std::uint16_t>(y),
            primitive,
            0xFFFF,
            0};
}

// An operation on one partition that holds the whole image.
class TestFrame {
 public:
    // `record`: the log keeps every operation, not only totals.
    TestFrame(const std::string& technique, TraceHeader header, std::uint64_t seed = 0,
              std::uint64_t pool_nodes = 1u << 20, bool record = true)
        : header_(std::move(header)),
          operation_(make(technique, header_, seed)),
          store_(operation_->declaration(), header_, pool_nodes, operation_->pixel_constant()),
          log_(operation_->declaration(), record),
          stores_(header_.width, header_.height,
                  std::vector<const PixelStore*>(static_cast<std::size_t>(tiles_across(header_.width)) *
                                                     static_cast<std::size_t>(tiles_across(header_.height)),
                                                 &store_)) {}
    TestFrame(const TestFrame&) = delete;
    TestFrame& operator=(const TestFrame&) = delete;

    static std::unique_ptr<FramebufferOperation> make(const std::string& technique, const TraceHeader& header,
                                                      std::uint64_t seed = 0) {
        TechniqueSpec spec = parse_technique(technique, "--technique");
        return make_operation(spec, screen_of(header, seed));
    }

    int passes() const { return static_cast<int>(declaration().passes.size()); }
    void draw_pass(int pass, std::span<const Fragment> fragments, int round = 0,
                   std::span<const DepthSlope> slopes = {}, std::span<const Material> materials = {}) {
        std::vector<std::uint32_t> indices(fragments.size());
        std::iota(indices.begin(), indices.end(), 0u);
        operation_->run(pass, round, {fragments, slopes, materials}, indices, store_, log_);
    }
    // Over every tile, touched or not.
    void image_pass(int pass, int round = 0) {
        for (int ty = 0; ty < tiles_across(header_.height); ++ty)
            for (int tx = 0; tx < tiles_across(header_.width); ++tx)
                operation_->image_pass(pass, round, store_, stores_, tx, ty, log_);
    }
    // Every pass in its order, rounds and restored surfaces included.
    void draw(std::span<const Fragment> fragments, std::span<const DepthSlope> slopes = {},
              std::span<const Material> materials = {}) {
        PassSequence sequence(declaration());
        while (!sequence.done()) {
            const Pass& pass = sequence.current();
            if (sequence.round() > 0) store_.restore(pass.restores);
            if (pass.kind == PassKind::kImage)
                image_pass(sequence.pass(), sequence.round());
            else
                draw_pass(sequence.pass(), at_resolution(fragments, header_, pass.scale), sequence.round(),
                          slopes, materials);
            const int watched = sequence.watched_path();
            sequence.advance(watched < 0 ? 0 : log_.path_count(static_cast<std::size_t>(watched)));
        }
    }
    void draw_one(const Fragment& fragment) { draw({&fragment, 1}); }

    // The resolved image, 3 floats a pixel, row by row; every tile is touched.
    std::vector<float> image() {
        std::vector<float> rgb(static_cast<std::size_t>(3 * header_.width * header_.height));
        std::array<float, std::size_t{3} * kTilePixels> tile;
        for (int ty = 0; ty < tiles_across(header_.height); ++ty) {
            for (int tx = 0; tx < tiles_across(header_.width); ++tx) {
                operation_->resolve(store_, stores_, tx, ty, tile.data(), log_);
                for (int i = 0; i < kTilePixels; ++i) {
                    const int x = tx * kTileSize + i % kTileSize;
                    const int y = ty * kTileSize + i / kTileSize;
                    if (x < header_.width && y < header_.height)
                        std::copy_n(&tile[static_cast<std::size_t>(3 * i)], 3,
                                    &rgb[static_cast<std::size_t>(3 * (y * header_.width + x))]);
                }
            }
        }
        return rgb;
    }
    std::array<float, 3> color(int x = 0, int y = 0) {
        const std::vector<float> all = image();
        const auto at = static_cast<std::size_t>(3 * (y * header_.width + x));
        return {all[at], all[at + 1], all[at + 2]};
    }
    std::span<const std::uint32_t> words(int x, int y) {
        return {store_.pixel(x, y), static_cast<std::size_t>(declaration().pixel_words)};
    }

    const TraceHeader& header() const { return header_; }
    const FramebufferOperation& operation() const { return *operation_; }
    const Declaration& declaration() const { return operation_->declaration(); }
    PixelStore& store() { return store_; }
    const StoreMap& stores() const { return stores_; }
    OperationLog& log() { return log_; }

 private:
    TraceHeader header_;
    std::unique_ptr<FramebufferOperation> operation_;
    PixelStore store_;
    OperationLog log_;
    StoreMap stores_;
};

// Latencies in the order of Unit: adder, multiplier, divider, comparator, mux, integer adder, integer
// multiplier, logic, converter, random, table, transcendental, fetch stage. Muxes are free, as behind a
// register.
inline DatapathShape plain_shape() {
    return {{2, 2, 8, 1, 0, 1, 2, 1, 1, 2, 1, 6, 4}, {}};
}
// Distinct primes: two different chains of units never have the same latency by accident of equal units.
inline DatapathShape prime_shape() {
    return {{3, 5, 17, 7, 11, 13, 19, 2, 23, 29, 31, 41, 37}, {}};
}

// One pixel's fragments, nearest first; of equal depths the earlier arrival is nearer. (Not by
// std::stable_sort: its buffer in libstdc++ 12 ignores the alignment of a Fragment.)
inline std::vector<Fragment> nearest_first(std::span<const Fragment> fragments, int x, int y) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < fragments.size(); ++i)
        if (fragments[i].x == x && fragments[i].y == y) order.push_back(i);
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return fragments[i].z; });
    std::vector<Fragment> own;
    for (const std::size_t i : order) own.push_back(fragments[i]);
    return own;
}

// Exact compositing of one pixel's fragments, which are picked out.
inline std::array<double, 3> composited(std::span<const Fragment> fragments, int x, int y,
                                        std::array<double, 3> background) {
    const std::vector<Fragment> own = nearest_first(fragments, x, y);
    std::array<double, 3> color = background;
    for (auto f = own.rbegin(); f != own.rend(); ++f) {
        const double t = 1.0 - static_cast<double>(f->a);
        color = {f->r + t * color[0], f->g + t * color[1], f->b + t * color[2]};
    }
    return color;
}

// Largest difference between the frame's image and exact compositing of `fragments`.
inline double worst_error(TestFrame& frame, std::span<const Fragment> fragments) {
    const std::vector<float> image = frame.image();
    const TraceHeader& header = frame.header();
    double worst = 0;
    for (int y = 0; y < header.height; ++y) {
        for (int x = 0; x < header.width; ++x) {
            const auto exact = composited(fragments, x, y, background_of(header, x, y));
            for (int c = 0; c < 3; ++c) {
                const double got = image[static_cast<std::size_t>(3 * (y * header.width + x) + c)];
                worst = std::max(worst, std::abs(got - exact[static_cast<std::size_t>(c)]));
            }
        }
    }
    return worst;
}

// Bytes the accesses of one operation move when nothing is cached.
struct AccessBytes {
    std::uint64_t read = 0;
    std::uint64_t write = 0;
};
inline AccessBytes bytes_of(const Declaration& declaration, const SurfaceAccess* access) {
    AccessBytes bytes;
    for (std::size_t s = 0; s < declaration.surfaces.size(); ++s) {
        bytes.read += access_bytes(declaration.surfaces[s], access[s].read);
        bytes.write += access_bytes(declaration.surfaces[s], access[s].write);
    }
    return bytes;
}

// n over k as a double.
inline double binomial(int n, int k) {
    if (k < 0 || k > n) return 0;
    double value = 1;
    for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
    return value;
}

}  // namespace ropsim::test
