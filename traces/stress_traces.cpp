// Small traces at the edges of what fragments can be, each for a reason of its own.
#include "traces/stress_traces.h"

#include "base/error.h"
#include "base/random.h"
#include "traces/trace.h"

#include <algorithm>
#include <array>
#include <limits>

namespace ropsim {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// A trace while it is made: a header, its fragments, and random numbers for them.
class Maker {
 public:
    Maker(int width, int height, std::uint64_t seed) : seed_(mix64(seed + 0x9E3779B97F4A7C15ull)) {
        header.width = width;
        header.height = height;
        header.background = {0.25f, 0.5f, 0.75f};
        header.draws.emplace_back().name = "stress";
    }

    // Appends a fragment of random colour; primitives count up.
    Fragment& add(int x, int y, float z, float a) {
        const std::uint64_t key = mix64(seed_ + content.size());
        content.fragments.push_back({z, a * random_unit(key, 0), a * random_unit(key, 1),
                                     a * random_unit(key, 2), a, static_cast<std::uint16_t>(x),
                                     static_cast<std::uint16_t>(y),
                                     static_cast<std::uint32_t>(content.size()), 1, 0});
        return content.fragments.back();
    }
    float unit(std::uint32_t stream) const { return random_unit(mix64(seed_ + content.size()), 16 + stream); }

    // Fisher and Yates' shuffle of what there is.
    void shuffle() {
        for (std::size_t i = content.size(); i > 1; --i)
            std::swap(content.fragments[i - 1], content.fragments[mix64(seed_ ^ mix64(i)) % i]);
    }
    template <typename Add>
    void at_every_pixel(Add&& add_here) {
        for (int y = 0; y < header.height; ++y)
            for (int x = 0; x < header.width; ++x) add_here(x, y);
    }

    TraceHeader header;
    FragmentChunk content;

 private:
    const std::uint64_t seed_;
};

// Twelve full-screen layers of one depth from three draws: only the arrival order tells which is nearer.
Maker coplanar(std::uint64_t seed) {
    Maker t(64, 64, seed);
    t.header.draws.resize(3, t.header.draws[0]);
    for (int layer = 0; layer < 12; ++layer)
        t.at_every_pixel([&](int x, int y) {
            t.add(x, y, 0.5f, 0.1f + 0.8f * t.unit(0)).draw = static_cast<std::uint16_t>(layer % 3);
        });
    return t;
}

// 10,000 fragments at one pixel among pixels of one: lists, node pools and queues that assume a bound.
Maker deep_pixel(std::uint64_t seed) {
    Maker t(16, 16, seed);
    t.at_every_pixel([&](int x, int y) {
        if (x != 5 || y != 10) t.add(x, y, t.unit(0), t.unit(1));
    });
    while (t.content.size() < 255 + 10000) t.add(5, 10, t.unit(0), 0.001f + 0.019f * t.unit(1));
    t.shuffle();
    return t;
}

// Behind eight transparent layers eight opaque ones, in any order: all but the nearest opaque one is
// invisible, so what a bounded list drops or merges must not show through.
Maker opaque_tail(std::uint64_t seed) {
    Maker t(32, 32, seed);
    for (int layer = 0; layer < 16; ++layer)
        t.at_every_pixel([&](int x, int y) {
            const bool opaque = layer >= 8;
            t.add(x, y, (opaque ? 0.5f : 0.0f) + 0.5f * t.unit(0), opaque ? 1.0f : 0.1f + 0.3f * t.unit(1));
        });
    t.shuffle();
    return t;
}

// Alpha exactly 0, half of them glowing (colour without alpha adds light), and exactly 1: divisions by alpha
// or by 1 - alpha, logarithms of it, and tests that drop fragments of alpha 0.
Maker extreme_alpha(std::uint64_t seed) {
    Maker t(32, 32, seed);
    for (int layer = 0; layer < 8; ++layer)
        t.at_every_pixel([&](int x, int y) {
            const float z = t.unit(0);
            const float glow = 0.1f * t.unit(1);
            const bool opaque = t.unit(2) < 0.25f;
            Fragment& f = t.add(x, y, z, opaque ? 1.0f : 0.0f);
            if (!opaque && layer % 2 == 0) f.r = f.g = f.b = glow;
        });
    return t;
}

// 1,000 layers of alpha 1e-4: together they hide 1 - (1 - 1e-4)^1000 = 9.5%, of which 8 bits a layer keep
// nothing.
Maker thin_media(std::uint64_t seed) {
    Maker t(16, 16, seed);
    for (int layer = 0; layer < 1000; ++layer)
        t.at_every_pixel([&](int x, int y) { t.add(x, y, t.unit(0), 1e-4f); });
    return t;
}

// Both ends of the depth range and neighbours one ulp apart: fixed-point depths, depth tests against the
// clear value, and bins whose last one has no end.
Maker depth_ends(std::uint64_t seed) {
    Maker t(32, 32, seed);
    constexpr float kSmallest = std::numeric_limits<float>::denorm_min();
    constexpr std::array<float, 10> kDepths{
        0.0f, kSmallest,       0x1p-126f,       0x1p-24f,        0.5f - 0x1p-25f,
        0.5f, 0.5f + 0x1p-24f, 1.0f - 0x1p-23f, 1.0f - 0x1p-24f, 1.0f};
    for (const float z : kDepths)
        t.at_every_pixel([&](int x, int y) { t.add(x, y, z, 0.2f + 0.6f * t.unit(0)); });
    t.shuffle();
    return t;
}

// A pixel for each channel and each value that no technique expects, before and behind ordinary fragments:
// what a shader's division by zero sends, and depths and alphas outside [0, 1].
Maker non_finite(std::uint64_t seed) {
    constexpr std::array<float, 7> kValues{kNan, kInfinity, -kInfinity, -0.5f, 1.5f, -0.0f, 3e38f};
    constexpr int kChannels = 15;  // z, r, g, b, a, two slopes, eight of the material
    Maker t(kChannels, static_cast<int>(kValues.size()), seed);
    t.header.non_finite = t.header.depth_slopes = t.header.materials = true;
    t.at_every_pixel([&](int x, int y) {
        for (const float z : {0.75f, 0.5f, 0.25f}) {
            t.add(x, y, z, 0.5f);
            t.content.slopes.push_back({0.001f, -0.002f});
            t.content.materials.push_back({{0.1f, 0.2f, 0.3f}, 0.5f, 1.5f, {0, 0, 1}});
            if (z != 0.5f) continue;
            Fragment& f = t.content.fragments.back();
            DepthSlope& s = t.content.slopes.back();
            Material& m = t.content.materials.back();
            const std::array<float*, kChannels> channels{&f.z,
                                                         &f.r,
                                                         &f.g,
                                                         &f.b,
                                                         &f.a,
                                                         &s.dx,
                                                         &s.dy,
                                                         &m.transmission[0],
                                                         &m.transmission[1],
                                                         &m.transmission[2],
                                                         &m.collimation,
                                                         &m.eta,
                                                         &m.normal[0],
                                                         &m.normal[1],
                                                         &m.normal[2]};
            *channels[static_cast<std::size_t>(x)] = kValues[static_cast<std::size_t>(y)];
        }
    });
    return t;
}

Maker single_fragment(std::uint64_t seed) {
    Maker t(64, 64, seed);
    t.add(31, 17, 0.5f, 0.5f);
    return t;
}

Maker empty(std::uint64_t seed) {
    return {64, 64, seed};
}

// 67 million pixels of which few are touched: whatever is sized or swept by the image and not by its
// fragments.
Maker large_image(std::uint64_t seed) {
    constexpr int kSide = 8192;
    constexpr int kStep = 64;
    Maker t(kSide, kSide, seed);
    for (int top = 0; top < kSide; top += kStep)
        for (int left = 0; left < kSide; left += kStep) {
            const int x = left + static_cast<int>(t.unit(0) * kStep);
            const int y = top + static_cast<int>(t.unit(1) * kStep);
            t.add(x, y, t.unit(2), t.unit(3));
        }
    for (const int y : {0, kSide - 1})
        for (const int x : {0, kSide - 1}) t.add(x, y, t.unit(2), t.unit(3));
    t.shuffle();
    return t;
}

struct Entry {
    StressTrace described;
    Maker (*make)(std::uint64_t seed);
};

constexpr std::array<Entry, 10> kEntries{{
    {{"coplanar", "12 full-screen layers at one depth: arrival order alone decides"}, coplanar},
    {{"deep_pixel", "one pixel 10,000 fragments deep: bounded lists and queues"}, deep_pixel},
    {{"opaque_tail", "8 transparent layers before 8 opaque ones: nothing behind may show through"},
     opaque_tail},
    {{"extreme_alpha", "alpha exactly 0, with and without colour, and exactly 1: divisions and logarithms"},
     extreme_alpha},
    {{"thin_media", "1,000 layers of alpha 1e-4: what rounding loses in sums"}, thin_media},
    {{"depth_ends", "depths 0, denormal, one ulp apart, and 1: depth formats and bins"}, depth_ends},
    {{"non_finite", "NaN, infinity and values out of range in every channel: what shaders can send"},
     non_finite},
    {{"single_fragment", "one fragment: everything that divides by a count"}, single_fragment},
    {{"empty", "no fragment at all"}, empty},
    {{"large_image", "8192x8192 pixels, 16,388 fragments spread over them: what is sized by the image"},
     large_image},
}};

}  // namespace

const std::vector<StressTrace>& stress_traces() {
    static const std::vector<StressTrace> list = [] {
        std::vector<StressTrace> all;
        for (const Entry& entry : kEntries) all.push_back(entry.described);
        return all;
    }();
    return list;
}

void write_stress_trace(const std::string& name, const std::string& path, std::uint64_t seed) {
    const auto entry = std::find_if(kEntries.begin(), kEntries.end(),
                                    [&](const Entry& e) { return e.described.name == name; });
    if (entry == kEntries.end()) {
        std::string names;
        for (const Entry& e : kEntries) names += (names.empty() ? "" : ", ") + std::string(e.described.name);
        throw UserError(name, "no such stress trace; choose one of " + names);
    }
    Maker trace = entry->make(seed);
    trace.header.scene = fmt::format("stress: {}, seed {}", name, seed);
    TraceWriter writer(path, trace.header);
    writer.append(trace.content);
    writer.finish();
}

}  // namespace ropsim
