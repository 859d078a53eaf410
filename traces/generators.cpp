// Seeded synthetic traces for tests, demonstrations and benchmarks.
#include "traces/generators.h"

#include "base/error.h"
#include "base/random.h"
#include "traces/half_float.h"
#include "traces/sample_positions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace ropsim {

namespace {

// Streams of draws from one key, so that no two properties of a fragment are correlated.
enum Stream : std::uint32_t {
    kPixelX,
    kPixelY,
    kDepth,
    kAlphaStream,
    kRedStream,
    kGreenStream,
    kBlueStream,
    kDrawStream,
    kMask,
    kSlopeStream,
    kMaterialStream = kSlopeStream + 2
};

int below(std::uint64_t key, std::uint32_t stream, int end) {
    return static_cast<int>((std::uint64_t{random_bits(key, stream)} * static_cast<std::uint64_t>(end)) >>
                            32);
}

void round_color(Fragment& fragment, ColorStorage storage) {
    if (storage != ColorStorage::kFloat16) return;
    for (const auto channel : {&Fragment::r, &Fragment::g, &Fragment::b})
        fragment.*channel = float_from_half(half_from_float(fragment.*channel));
}

Fragment random_fragment(const RandomFragments& options, std::uint64_t index) {
    const std::uint64_t key = mix64(options.seed * 0x9E3779B97F4A7C15ull + index);
    const int levels = options.depth_levels > 0 ? options.depth_levels : 1 << 20;
    const auto all = static_cast<int>((1u << options.samples) - 1);
    Fragment f{};
    f.x = static_cast<std::uint16_t>(below(key, kPixelX, options.width));
    f.y = static_cast<std::uint16_t>(below(key, kPixelY, options.height));
    f.z = (static_cast<float>(below(key, kDepth, levels)) + 0.5f) / static_cast<float>(levels);
    f.a = options.alpha_low + (options.alpha_high - options.alpha_low) * random_unit(key, kAlphaStream);
    f.r = f.a * random_unit(key, kRedStream);
    f.g = f.a * random_unit(key, kGreenStream);
    f.b = f.a * random_unit(key, kBlueStream);
    f.primitive = static_cast<std::uint32_t>(index);
    f.coverage = static_cast<std::uint16_t>(options.partial_coverage ? 1 + below(key, kMask, all) : all);
    f.draw = static_cast<std::uint16_t>(below(key, kDrawStream, options.draws));
    round_color(f, options.color_storage);
    return f;
}

Material random_material(std::uint64_t key, ColorStorage storage) {
    const auto unit = [&](std::uint32_t i) {
        const float value = random_unit(key, kMaterialStream + i);
        return storage == ColorStorage::kFloat16 ? float_from_half(half_from_float(value)) : value;
    };
    Material m;
    for (std::uint32_t c = 0; c < 3; ++c) {
        m.transmission[c] = unit(c);
        m.normal[c] = c == 2 ? 1 - unit(3) : unit(3 + c) - 0.5f;
        if (storage == ColorStorage::kFloat16) m.normal[c] = float_from_half(half_from_float(m.normal[c]));
    }
    m.collimation = unit(6);
    m.eta = 1 + unit(7);
    if (storage == ColorStorage::kFloat16) m.eta = float_from_half(half_from_float(m.eta));
    return m;
}

// One rectangle of a layer: a plane of depth and colour with two triangles.
struct Rectangle {
    int left, top, right, bottom;
    float z, z_dx, z_dy;
    float red, green, blue, red_dx, green_dy;
    float alpha;
    std::uint32_t primitive;
    std::uint64_t key;
};

Rectangle make_rectangle(const LayeredScene& options, int layer, int column, int row,
                         std::uint32_t primitive) {
    const std::uint64_t key = mix64(options.seed + mix64((static_cast<std::uint64_t>(layer) << 40) +
                                                         (static_cast<std::uint64_t>(row) << 20) +
                                                         static_cast<std::uint64_t>(column)));
    const auto unit = [&](std::uint32_t draw) { return random_unit(key, draw); };
    Rectangle r{};
    r.left = column * options.cell;
    r.top = row * options.cell;
    r.right = std::min(options.width, r.left + options.cell);
    r.bottom = std::min(options.height, r.top + options.cell);
    r.z = 0.1f + 0.8f * unit(0);
    r.z_dx = (unit(1) - 0.5f) * 0.001f;
    r.z_dy = (unit(2) - 0.5f) * 0.001f;
    r.red = 0.2f + 0.6f * unit(3);
    r.green = 0.2f + 0.6f * unit(4);
    r.blue = 0.2f + 0.6f * unit(5);
    r.red_dx = (unit(6) - 0.5f) * 0.004f;
    r.green_dy = (unit(7) - 0.5f) * 0.004f;
    r.alpha = std::clamp(options.alpha + 0.4f * (unit(8) - 0.5f), 0.0f, 1.0f);
    r.primitive = primitive;
    r.key = key;
    return r;
}

Fragment shade(const LayeredScene& options, const Rectangle& r, int layer, int triangle, int x, int y) {
    const auto dx = static_cast<float>(x - r.left);
    const auto dy = static_cast<float>(y - r.top);
    const std::uint64_t texel = r.key + static_cast<std::uint64_t>(y) * 65536 + static_cast<std::uint64_t>(x);
    Fragment f{};
    f.x = static_cast<std::uint16_t>(x);
    f.y = static_cast<std::uint16_t>(y);
    f.z = std::clamp(r.z + dx * r.z_dx + dy * r.z_dy, 0.0f, 1.0f);
    f.a = r.alpha;
    if (options.textured_alpha) f.a *= std::round(255.0f * (0.75f + 0.25f * random_unit(texel, 0))) / 255.0f;
    f.r = f.a * std::clamp(r.red + dx * r.red_dx, 0.0f, 1.0f);
    f.g = f.a * std::clamp(r.green + dy * r.green_dy, 0.0f, 1.0f);
    f.b = f.a * (r.blue + 0.03f * (random_unit(texel, 1) - 0.5f));
    f.primitive = r.primitive + static_cast<std::uint32_t>(triangle);
    f.coverage = 1;
    f.draw = static_cast<std::uint16_t>(layer);
    round_color(f, options.color_storage);
    return f;
}

// Which spatial samples of a pixel lie in a triangle, by the diagonal that parts the rectangle; one alone is
// the pixel's corner.
std::uint16_t coverage_of(const LayeredScene& options, const Rectangle& r, int triangle, int x, int y) {
    const auto inside = [&](int dx16, int dy16) {
        const bool lower = dx16 * (r.bottom - r.top) < dy16 * (r.right - r.left);
        return lower == (triangle == 1);
    };
    const int x16 = 16 * (x - r.left);
    const int y16 = 16 * (y - r.top);
    if (options.samples == 1) return inside(x16, y16) ? 1 : 0;
    unsigned mask = 0;
    unsigned bit = 1;
    for (const SamplePosition& at : sample_positions(options.samples)) {
        if (inside(x16 + 8 + at.x16, y16 + 8 + at.y16)) mask |= bit;
        bit <<= 1;
    }
    return static_cast<std::uint16_t>(mask);
}

// The fragments of one triangle of the rectangle, in quads row by row.
void rasterise(const LayeredScene& options, const Rectangle& r, int layer, int triangle,
               std::vector<Fragment>& out) {
    for (int quad_y = r.top & ~1; quad_y < r.bottom; quad_y += 2)
        for (int quad_x = r.left & ~1; quad_x < r.right; quad_x += 2)
            for (int corner = 0; corner < 4; ++corner) {
                const int x = quad_x + (corner & 1);
                const int y = quad_y + (corner >> 1);
                if (x < r.left || y < r.top || x >= r.right || y >= r.bottom) continue;
                const std::uint16_t coverage = coverage_of(options, r, triangle, x, y);
                if (coverage == 0) continue;
                out.push_back(shade(options, r, layer, triangle, x, y));
                out.back().coverage = coverage;
            }
}

}  // namespace

TraceHeader random_header(const RandomFragments& options) {
    TraceHeader header;
    header.width = options.width;
    header.height = options.height;
    header.samples = options.samples;
    header.color_storage = options.color_storage;
    header.scene = "random fragments";
    header.background = {0.2f, 0.4f, 0.6f};
    for (int i = 0; i < options.draws; ++i) {
        Draw draw;
        draw.name = fmt::format("draw {}", i);
        draw.object_id = static_cast<std::uint32_t>(i);
        header.draws.push_back(draw);
    }
    header.depth_slopes = options.slopes;
    header.materials = options.materials;
    if (!options.opaque) return header;
    OpaqueLayer opaque;
    const std::uint64_t samples = static_cast<std::uint64_t>(options.width) *
                                  static_cast<std::uint64_t>(options.height) *
                                  static_cast<std::uint64_t>(options.samples);
    for (std::uint64_t sample = 0; sample < samples; ++sample) {
        const std::uint64_t key = mix64(mix64(options.seed) + sample);
        const bool drawn = random_bits(key, 4) & 1u;
        for (std::uint32_t c = 0; c < 3; ++c)
            opaque.rgb.push_back(drawn ? random_unit(key, c) : header.background[static_cast<int>(c)]);
        opaque.depth.push_back(drawn ? random_unit(key, 3) : std::numeric_limits<float>::infinity());
    }
    header.opaque = std::move(opaque);
    return header;
}

std::vector<Fragment> random_fragments(const RandomFragments& options) {
    CHECK(options.draws >= 1 && options.width >= 1 && options.height >= 1 && options.samples >= 1);
    std::vector<Fragment> fragments(options.count);
    for (std::uint64_t i = 0; i < options.count; ++i) fragments[i] = random_fragment(options, i);
    using Order = RandomFragments::Order;
    if (options.order != Order::kBackToFront && options.order != Order::kFrontToBack) return fragments;
    // Numbers are sorted, not fragments: std::stable_sort's buffer knows nothing of their alignment.
    std::vector<std::uint64_t> numbers(fragments.size());
    std::iota(numbers.begin(), numbers.end(), std::uint64_t{0});
    const bool back_to_front = options.order == Order::kBackToFront;
    std::stable_sort(numbers.begin(), numbers.end(), [&](std::uint64_t a, std::uint64_t b) {
        return back_to_front ? fragments[a].z > fragments[b].z : fragments[a].z < fragments[b].z;
    });
    std::vector<Fragment> sorted;
    sorted.reserve(fragments.size());
    for (const std::uint64_t number : numbers) sorted.push_back(fragments[number]);
    return sorted;
}

FragmentChunk random_chunk(const RandomFragments& options) {
    FragmentChunk chunk;
    chunk.fragments = random_fragments(options);
    for (const Fragment& fragment : chunk.fragments) {
        // A fragment's primitive is its number in the order of generation.
        const std::uint64_t key = mix64(options.seed * 0x9E3779B97F4A7C15ull + fragment.primitive);
        if (options.slopes)
            chunk.slopes.push_back({0.02f * (random_unit(key, kSlopeStream) - 0.5f),
                                    0.02f * (random_unit(key, kSlopeStream + 1) - 0.5f)});
        if (options.materials) chunk.materials.push_back(random_material(key, options.color_storage));
    }
    return chunk;
}

TraceHeader layered_header(const LayeredScene& options) {
    TraceHeader header;
    header.width = options.width;
    header.height = options.height;
    header.samples = options.samples;
    header.color_storage = options.color_storage;
    header.scene = "synthetic layers";
    header.background = {0.1f, 0.1f, 0.1f};
    for (int layer = 0; layer < options.layers; ++layer) {
        Draw draw;
        draw.name = fmt::format("layer {}", layer);
        draw.object_id = static_cast<std::uint32_t>(layer);
        header.draws.push_back(draw);
    }
    return header;
}

void append_layered(const LayeredScene& options, TraceWriter& writer) {
    std::vector<Fragment> fragments;
    const int columns = (options.width + options.cell - 1) / options.cell;
    const int rows = (options.height + options.cell - 1) / options.cell;
    for (int layer = 0; layer < options.layers; ++layer)
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns; ++column) {
                const auto primitive = static_cast<std::uint32_t>(2 * (row * columns + column));
                const Rectangle r = make_rectangle(options, layer, column, row, primitive);
                fragments.clear();
                for (int triangle = 0; triangle < 2; ++triangle)
                    rasterise(options, r, layer, triangle, fragments);
                writer.append(fragments);
            }
}

void write_trace(const std::string& path, const TraceHeader& header, const std::vector<Fragment>& fragments) {
    TraceWriter writer(path, header);
    writer.append(fragments);
    writer.finish();
}

std::vector<Fragment> read_fragments(const std::string& path) {
    TraceReader reader(path);
    std::vector<Fragment> all;
    std::vector<Fragment> chunk;
    while (reader.next(chunk)) all.insert(all.end(), chunk.begin(), chunk.end());
    return all;
}

}  // namespace ropsim
