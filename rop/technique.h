// What a technique's author includes: the fragment as an operation sees it, the concept a technique
// satisfies, and the adapter that turns it into a FramebufferOperation.
#pragma once

#include "base/random.h"
#include "rop/operation.h"
#include "traces/depth_test.h"

#include <array>
#include <concepts>

namespace ropsim {

// Where a fragment stands in the order in which things are drawn.
struct DrawOrder {
    std::uint32_t draw = 0;
    std::uint32_t primitive = 0;  // within the draw, below 2^31
};

// A fragment's attributes on the datapath's wires, all ready at the start.
template <class D>
struct FragmentInput {
    typename D::Real z;
    typename D::Real a;
    Rgb<D> premultiplied;
    typename D::Uint coverage;  // bit m: spatial sample m
    typename D::Uint
        pixel_constant;  // the technique's own word of this pixel (see Technique::pixel_constant)
    std::uint64_t key;   // of random draws: seed, pixel, draw and primitive, or as the technique keys them
    DrawOrder order;
    int x, y;   // the pixel
    int round;  // of a repeated pass, from 0
    int spatial_samples;
    // Depth of the fragment's plane at each spatial sample, as the rasteriser hands it down for the depth
    // test; set where the trace has more than one.
    std::array<typename D::Real, kMaxSpatialSamples> sample_z;

    // The colour a shader exports to techniques that store it unmultiplied. The trace keeps only the product,
    // so it is divided out here, outside the operation: the division is the trace's, not the hardware's.
    Rgb<D> straight() const {
        const float inverse_alpha = value_of(a) > 0.0f ? 1.0f / value_of(a) : 0.0f;
        return {value_of(premultiplied.r) * inverse_alpha, value_of(premultiplied.g) * inverse_alpha,
                value_of(premultiplied.b) * inverse_alpha};
    }
    const typename D::Real& depth_at(int spatial_sample) const {
        return spatial_samples == 1 ? z : sample_z[static_cast<std::size_t>(spatial_sample)];
    }
};

// What is behind a pixel, on the datapath's wires.
template <class D>
struct Background {
    Rgb<D> mean;
    int samples = 1;
    std::array<Rgb<D>, kMaxSpatialSamples> sample;  // the first `samples`

    explicit Background(const PixelBackground& b) : mean{b.mean.r, b.mean.g, b.mean.b}, samples(b.samples) {
        for (std::size_t m = 0; m < static_cast<std::size_t>(samples); ++m)
            sample[m] = {b.sample[m].r, b.sample[m].g, b.sample[m].b};
    }
};

// A tile's functional words with a border of `footprint` pixels around it, and what is behind them.
struct HaloTile {
    HaloTile(const StoreMap& stores, int tile_x, int tile_y, int footprint)
        : border(footprint), side(kTileSize + 2 * footprint) {
        const PixelWindow window(stores);
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const int u = tile_x * kTileSize + x - border;
                const int v = tile_y * kTileSize + y - border;
                window.copy(u, v, words.emplace_back());
                background.push_back(window.background(u, v));
            }
    }
    int border;
    int side;
    std::vector<std::vector<std::uint32_t>> words;
    std::vector<PixelBackground> background;
};

// The pixels around one, read only. Fetches of all of them are the same bytes of each.
template <class P>
class Window {
 public:
    using D = typename P::D;
    // x, y: the pixel in its tile.
    Window(HaloTile& halo, int x, int y, PixelAccess& access, bool worst)
        : halo_(halo), x_(x + halo.border), y_(y + halo.border), access_(access), worst_(worst) {}
    int footprint() const { return halo_.border; }
    P at(int dx, int dy) {
        if constexpr (D::kCharged)
            return P(halo_.words[index(dx, dy)].data(), access_, nullptr, worst_);
        else
            return P(halo_.words[index(dx, dy)].data(), access_, nullptr);
    }
    Background<D> background(int dx, int dy) const { return Background<D>(halo_.background[index(dx, dy)]); }

 private:
    std::size_t index(int dx, int dy) const {
        return static_cast<std::size_t>(y_ + dy) * static_cast<std::size_t>(halo_.side) +
               static_cast<std::size_t>(x_ + dx);
    }
    HaloTile& halo_;
    int x_;
    int y_;
    PixelAccess& access_;
    bool worst_;
};

// A technique has a static kInfo (TechniqueInfo), declares surfaces, passes and paths, and writes its
// operation once over any datapath:
//   int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const    returns the control path taken
//   Rgb<D> resolve(D& d, const Background<D>& background, P& pixel, int& path) const
// and, if it declares such passes or a footprint,
//   int image_pass(D& d, int pass, P& pixel) const                             returns the control path taken
//   Rgb<D> resolve_window(D& d, Window<P>& window, int& path) const            instead of resolve
// Branches that hardware takes as separate control paths go through d.decide(); everything else selects.
template <class T>
concept Technique = std::constructible_from<T, Parameters&, const Screen&> &&
    requires(const T t, PlainDatapath d, const FragmentInput<PlainDatapath>& f, PlainPixel& p,
             const Background<PlainDatapath>& background, int& path, ChargedDatapath cd,
             const FragmentInput<ChargedDatapath>& cf, ChargedPixel& cp,
             const Background<ChargedDatapath>& cbackground) {
    { T::kInfo } -> std::convertible_to<TechniqueInfo>;
    { t.declaration() } -> std::convertible_to<const Declaration&>;
    { t.fragment(d, 0, f, p) } -> std::same_as<int>;
    { t.fragment(cd, 0, cf, cp) } -> std::same_as<int>;
    { t.resolve(d, background, p, path) } -> std::same_as<Rgb<PlainDatapath>>;
    { t.resolve(cd, cbackground, cp, path) } -> std::same_as<Rgb<ChargedDatapath>>;
};

// A technique may keep one word a pixel that depends on its place and what is behind it only:
// std::uint32_t pixel_constant(int x, int y, glm::vec3 background).
template <class T>
concept HasPixelConstant = requires(const T t) {
    { t.pixel_constant(0, 0, glm::vec3(0.0f)) } -> std::same_as<std::uint32_t>;
};

// A technique that draws in some of its passes only says so: bool draws(int pass) const.
//
// A technique may key its random draws itself: std::uint64_t random_key(const Fragment&) const.
template <class T>
concept HasRandomKey = requires(const T t, const Fragment& f) {
    { t.random_key(f) } -> std::same_as<std::uint64_t>;
};

template <class T>
concept HasImagePass = requires(const T t, PlainDatapath d, PlainPixel& p) {
    { t.image_pass(d, 0, p) } -> std::same_as<int>;
};

template <class T>
concept HasWindow = requires(const T t, PlainDatapath d, Window<PlainPixel>& w, int& path) {
    { t.resolve_window(d, w, path) } -> std::same_as<Rgb<PlainDatapath>>;
};

template <Technique T>
class OperationOf : public FramebufferOperation {
 public:
    OperationOf(Parameters& parameters, const Screen& screen)
        : technique_(parameters, screen), screen_(screen) {}

    const Declaration& declaration() const override { return technique_.declaration(); }

    void run(int pass, int round, const FragmentSpan& fragments, std::span<const std::uint32_t> indices,
             PixelStore& store, OperationLog& log) const override {
        const bool many_surfaces = technique_.declaration().surfaces.size() > kFewSurfaces;
        for (std::size_t i = 0; i < indices.size(); ++i) {
            const std::uint32_t index = indices[i];
            if (i + kFragmentPrefetch < indices.size()) {
                __builtin_prefetch(&fragments.fragments[indices[i + kFragmentPrefetch]]);
                const Fragment& later = fragments.fragments[indices[i + kPixelPrefetch]];
                store.prefetch(later.x, later.y);
            }
            const Fragment& f = fragments.fragments[index];
            const DepthSlope slope = fragments.slopes.empty() ? DepthSlope{} : fragments.slopes[index];
            std::uint32_t* words = store.pixel(f.x, f.y);
            PixelAccess access;
            clear(access, many_surfaces);
            PlainDatapath d;
            PlainPixel pixel(words, access, store.pool());
            FragmentInput<PlainDatapath> in;
            set_input(in, pass, f, slope, round, words, store);
            const int path = technique_.fragment(d, pass, in, pixel);
            log.add(path, access, d.step_count);
        }
    }

    void image_pass(int pass, int, PixelStore& store, int tile_x, int tile_y,
                    OperationLog& log) const override {
        for_pixels(tile_x, tile_y, [&](int, int x, int y) {
            PixelAccess access{};
            PlainDatapath d;
            PlainPixel pixel(store.pixel(x, y), access, store.pool());
            log.add(run_image_pass(d, pass, pixel), access, d.step_count);
        });
    }

    void resolve(PixelStore& store, const StoreMap& stores, int tile_x, int tile_y, float* rgb,
                 OperationLog& log) const override {
        if (declaration().footprint > 0) return resolve_tile_window(stores, tile_x, tile_y, rgb, log);
        for_pixels(tile_x, tile_y, [&](int i, int x, int y) {
            PixelAccess access{};
            PlainDatapath d;
            PlainPixel pixel(store.pixel(x, y), access, store.pool());
            int path = 0;
            const Rgb<PlainDatapath> color =
                technique_.resolve(d, Background<PlainDatapath>(store.background(x, y)), pixel, path);
            write_color(color, rgb + std::ptrdiff_t{3} * i);
            if (!declaration().resolves) return;  // the image is read where it lies: no operation, no bytes
            log.add(path, access, d.step_count);
            if (store.pool() != nullptr) {
                log.add_walk(pool_surface(), store.pool()->visited());
                store.pool()->visited().clear();
            }
        });
    }

    CostTable cost(const DatapathShape& shape) const override;
    ChargedOutcome charged_fragment(const DatapathShape& shape, int pass, int round, const Fragment& fragment,
                                    const DepthSlope& slope, PixelStore& store) const override;
    ChargedOutcome charged_image_pass(const DatapathShape& shape, int pass, int round, PixelStore& store,
                                      int x, int y) const override;
    ChargedOutcome charged_resolve(const DatapathShape& shape, PixelStore& store, const StoreMap& stores,
                                   int x, int y, float* rgb) const override;

    PixelConstant pixel_constant() const override {
        if constexpr (HasPixelConstant<T>)
            return [this](int x, int y, glm::vec3 background) {
                return technique_.pixel_constant(x, y, background);
            };
        else
            return nullptr;
    }

 private:
    // In two halves: clearing all at once becomes a string instruction, slow to start, for each operation.
    static constexpr std::size_t kFewSurfaces = 4;
    static void clear(PixelAccess& access, bool many_surfaces) {
        for (std::size_t s = 0; s < kFewSurfaces; ++s) access[s] = {};
        if (!many_surfaces) return;
        for (std::size_t s = kFewSurfaces; s < kMaxTechniqueSurfaces; ++s) access[s] = {};
    }
    // How many operations ahead a fragment, and its pixel, are asked of memory.
    static constexpr std::size_t kFragmentPrefetch = 16;
    static constexpr std::size_t kPixelPrefetch = 4;

    // Calls body(number in the tile, x, y) for the tile's pixels inside the image, row by row.
    template <class Body>
    void for_pixels(int tile_x, int tile_y, Body body) const {
        for (int i = 0; i < kTilePixels; ++i) {
            const int x = tile_x * kTileSize + i % kTileSize;
            const int y = tile_y * kTileSize + i / kTileSize;
            if (x < screen_.width && y < screen_.height) body(i, x, y);
        }
    }
    template <class D, class P>
    int run_image_pass(D& d, int pass, P& pixel) const {
        if constexpr (HasImagePass<T>) {
            return technique_.image_pass(d, pass, pixel);
        } else {
            CHECK(false, "{} has no image passes", T::kInfo.name);
        }
    }
    template <class D, class P>
    Rgb<D> run_window(D& d, Window<P>& window, int& path) const {
        if constexpr (HasWindow<T>) {
            return technique_.resolve_window(d, window, path);
        } else {
            CHECK(false, "{} has no footprint", T::kInfo.name);
        }
    }
    void resolve_tile_window(const StoreMap& stores, int tile_x, int tile_y, float* rgb,
                             OperationLog& log) const {
        HaloTile halo(stores, tile_x, tile_y, declaration().footprint);
        const auto pixels =
            static_cast<std::uint64_t>(2 * halo.border + 1) * static_cast<std::uint64_t>(2 * halo.border + 1);
        for_pixels(tile_x, tile_y, [&](int i, int, int) {
            PixelAccess access{};
            PlainDatapath d;
            Window<PlainPixel> window(halo, i % kTileSize, i / kTileSize, access, false);
            int path = 0;
            write_color(run_window(d, window, path), rgb + std::ptrdiff_t{3} * i);
            log.add(path, access, d.step_count, pixels);
        });
    }
    std::uint64_t random_key(const Fragment& f) const {
        if constexpr (HasRandomKey<T>) return technique_.random_key(f);
        const std::uint64_t place =
            static_cast<std::uint64_t>(f.y) * static_cast<std::uint64_t>(screen_.width) + f.x;
        return mix64(mix64(screen_.seed * 0x9E3779B97F4A7C15ull + f.draw) ^ (place << 32) ^ f.primitive);
    }
    template <class D>
    void set_input(FragmentInput<D>& in, [[maybe_unused]] int pass, const Fragment& f,
                   const DepthSlope& slope, int round, const std::uint32_t* words,
                   const PixelStore& store) const {
        in.z = f.z;
        in.a = f.a;
        in.premultiplied = {f.r, f.g, f.b};
        in.coverage = static_cast<std::uint32_t>(f.coverage);
        if constexpr (HasPixelConstant<T>) in.pixel_constant = words[store.constant_word()];
        if constexpr (requires { technique_.draws(pass); }) {
            in.key = technique_.draws(pass) ? random_key(f) : 0;
        } else if constexpr (requires { T::kRandom; }) {
            in.key = random_key(f);
        }
        in.order = {f.draw, primitive_number(f)};
        in.x = f.x;
        in.y = f.y;
        in.round = round;
        in.spatial_samples = screen_.samples;
        if (screen_.samples == 1) return;
        const auto positions = sample_positions(screen_.samples);
        for (std::size_t m = 0; m < positions.size(); ++m)
            in.sample_z[m] = sample_depth(f, slope, positions[m]);
    }
    void write_color(const Rgb<PlainDatapath>& color, float* rgb) const {
        const Format format = declaration().image_format;
        const auto stored = stored_rgb(format, {color.r, color.g, color.b});
        std::copy(stored.begin(), stored.end(), rgb);
    }
    std::size_t pool_surface() const {
        const auto& surfaces = declaration().surfaces;
        for (std::size_t s = 0; s < surfaces.size(); ++s)
            if (surfaces[s].layout == Layout::kPool) return s;
        CHECK(false, "no pool surface");
    }
    void add_path(CostTable& table, const DatapathShape& shape, int path, int pass, const Work& work,
                  const ChargedDatapath& d, const PixelAccess& access) const;

    T technique_;
    Screen screen_;
};

namespace detail {
// The next script of decisions in binary order; false when all have been run.
inline bool next_script(std::vector<bool>& script) {
    while (!script.empty() && script.back()) script.pop_back();
    if (script.empty()) return false;
    script.back() = true;
    return true;
}
inline constexpr int kEnumerationNodes = 64;
}  // namespace detail

template <Technique T>
void OperationOf<T>::add_path(CostTable& table, const DatapathShape& shape, int path, int pass,
                              const Work& work, const ChargedDatapath& d, const PixelAccess& access) const {
    PathCost& entry = table.at(static_cast<std::size_t>(path));
    const bool first = entry.name.empty();
    CHECK(first || (entry.pass == pass && entry.work == work), "path '{}' is reached with different work",
          declaration().paths[static_cast<std::size_t>(path)]);
    entry.name = declaration().paths[static_cast<std::size_t>(path)];
    entry.pass = pass;
    entry.work = work;
    entry.step = d.step_work;
    entry.has_step = d.step_known;
    entry.interval = initiation_interval(work, shape);
    for (std::size_t k = 0; k < 2; ++k)
        entry.step_interval[k] = d.step_known[k] ? initiation_interval(d.step_work[k], shape) : 0;
    for (std::size_t s = 0; s < kMaxTechniqueSurfaces; ++s) {
        entry.worst[s].read |= access[s].read;
        entry.worst[s].write |= access[s].write;
    }
}

// Runs the operation once for every sequence of decisions it can take, on a cleared pixel whose values do not
// matter: decisions come from the script. So the table holds every control path, whether a scene reaches it
// or not.
template <Technique T>
CostTable OperationOf<T>::cost(const DatapathShape& shape) const {
    const Declaration& declared = declaration();
    CostTable table(declared.paths.size());
    TraceHeader one_pixel;
    one_pixel.width = one_pixel.height = 1;
    const int passes = static_cast<int>(declared.passes.size());
    for (int pass = kResolvePass; pass < passes; ++pass) {
        if (pass == kResolvePass && !declared.resolves) continue;
        std::vector<bool> script;
        do {
            PixelStore store(declared, one_pixel, detail::kEnumerationNodes, pixel_constant());
            const StoreMap stores(1, 1, {&store});
            if (store.pool() != nullptr) store.pool()->allocate();  // a node for one step of a list
            PixelAccess access{};
            ChargedDatapath d(&script);
            const Ledger ledger(shape);
            std::uint32_t* words = store.pixel(0, 0);
            ChargedPixel pixel(words, access, store.pool(), /*worst=*/true);
            int path = 0;
            if (pass == kResolvePass && declared.footprint > 0) {
                HaloTile halo(stores, 0, 0, declared.footprint);
                Window<ChargedPixel> window(halo, 0, 0, access, true);
                run_window(d, window, path);
            } else if (pass == kResolvePass) {
                PixelBackground background = store.background(0, 0);
                background.samples = screen_.samples;
                technique_.resolve(d, Background<ChargedDatapath>(background), pixel, path);
            } else if (declared.passes[static_cast<std::size_t>(pass)].kind == PassKind::kImage) {
                path = run_image_pass(d, pass, pixel);
            } else {
                const Fragment f{0.5f, 0.25f, 0.25f, 0.25f, 0.5f, 0, 0, 0, 0xFFFF, 0};
                FragmentInput<ChargedDatapath> in;
                set_input(in, pass, f, {}, 0, words, store);
                path = technique_.fragment(d, pass, in, pixel);
            }
            add_path(table, shape, path, pass, ledger.work(), d, access);
        } while (detail::next_script(script));
    }
    for (std::size_t p = 0; p < table.size(); ++p)
        CHECK(!table[p].name.empty(), "path '{}' is never taken", declared.paths[p]);
    return table;
}

template <Technique T>
ChargedOutcome OperationOf<T>::charged_fragment(const DatapathShape& shape, int pass, int round,
                                                const Fragment& fragment, const DepthSlope& slope,
                                                PixelStore& store) const {
    ChargedOutcome outcome;
    const Ledger ledger(shape);
    ChargedDatapath d;
    std::uint32_t* words = store.pixel(fragment.x, fragment.y);
    ChargedPixel pixel(words, outcome.access, store.pool(), /*worst=*/false);
    FragmentInput<ChargedDatapath> in;
    set_input(in, pass, fragment, slope, round, words, store);
    outcome.path = technique_.fragment(d, pass, in, pixel);
    outcome.work = ledger.work();
    outcome.steps = d.step_count;
    outcome.step_work = d.step_work;
    return outcome;
}

template <Technique T>
ChargedOutcome OperationOf<T>::charged_image_pass(const DatapathShape& shape, int pass, int,
                                                  PixelStore& store, int x, int y) const {
    ChargedOutcome outcome;
    const Ledger ledger(shape);
    ChargedDatapath d;
    ChargedPixel pixel(store.pixel(x, y), outcome.access, store.pool(), /*worst=*/false);
    outcome.path = run_image_pass(d, pass, pixel);
    outcome.work = ledger.work();
    return outcome;
}

template <Technique T>
ChargedOutcome OperationOf<T>::charged_resolve(const DatapathShape& shape, PixelStore& store,
                                               const StoreMap& stores, int x, int y, float* rgb) const {
    ChargedOutcome outcome;
    const Ledger ledger(shape);
    ChargedDatapath d;
    Rgb<ChargedDatapath> color;
    if (declaration().footprint > 0) {
        HaloTile halo(stores, x / kTileSize, y / kTileSize, declaration().footprint);
        Window<ChargedPixel> window(halo, x % kTileSize, y % kTileSize, outcome.access, false);
        color = run_window(d, window, outcome.path);
    } else {
        ChargedPixel pixel(store.pixel(x, y), outcome.access, store.pool(), /*worst=*/false);
        color =
            technique_.resolve(d, Background<ChargedDatapath>(store.background(x, y)), pixel, outcome.path);
    }
    write_color({color.r.value, color.g.value, color.b.value}, rgb);
    outcome.work = ledger.work();
    outcome.steps = d.step_count;
    outcome.step_work = d.step_work;
    if (store.pool() != nullptr) store.pool()->visited().clear();
    return outcome;
}

}  // namespace ropsim

// Ends a technique's file: makes the class known to the registry under the name of its line in registry.def.
// NOLINTBEGIN(bugprone-macro-parentheses): the class is a template argument.
#define ROPSIM_TECHNIQUE(name, Class)                                                                 \
    namespace ropsim::techniques {                                                                    \
    TechniqueInfo name##_info() {                                                                     \
        return Class::kInfo;                                                                          \
    }                                                                                                 \
    std::unique_ptr<FramebufferOperation> make_##name(Parameters& parameters, const Screen& screen) { \
        return std::make_unique<OperationOf<Class>>(parameters, screen);                              \
    }                                                                                                 \
    }
// NOLINTEND(bugprone-macro-parentheses)
