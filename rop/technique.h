// What a technique's author includes: the fragment as an operation sees it, the concept a technique
// satisfies, and the adapter that turns it into a FramebufferOperation.
#pragma once

#include "base/random.h"
#include "rop/operation.h"

#include <concepts>

namespace ropsim {

// A fragment's attributes on the datapath's wires, all ready at the start.
template <class D>
struct FragmentInput {
    typename D::Real z;
    typename D::Real a;
    Rgb<D> premultiplied;
    // The colour a shader exports to techniques that store it unmultiplied. The trace keeps only the product,
    // so it is divided out here, outside the operation: the division is the trace's, not the hardware's.
    Rgb<D> straight;
    typename D::Uint coverage;  // bit m: spatial sample m
    typename D::Uint
        pixel_constant;  // the technique's own word of this pixel (see Technique::pixel_constant)
    std::uint64_t key;   // of random draws: seed, pixel, draw and primitive
};

// A technique has a static kInfo (TechniqueInfo), declares surfaces, passes and paths, and writes its
// operation once over any datapath:
//   int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const    returns the control path taken
//   Rgb<D> resolve(D& d, const Rgb<D>& background, P& pixel, int& path) const
// Branches that hardware takes as separate control paths go through d.decide(); everything else selects.
template <class T>
concept Technique = std::constructible_from<T, Parameters&, const Screen&> &&
    requires(const T t, PlainDatapath d, const FragmentInput<PlainDatapath>& f, PlainPixel& p,
             const Rgb<PlainDatapath>& background, int& path, ChargedDatapath cd,
             const FragmentInput<ChargedDatapath>& cf, ChargedPixel& cp,
             const Rgb<ChargedDatapath>& cbackground) {
    { T::kInfo } -> std::convertible_to<TechniqueInfo>;
    { t.declaration() } -> std::convertible_to<const Declaration&>;
    { t.fragment(d, 0, f, p) } -> std::same_as<int>;
    { t.fragment(cd, 0, cf, cp) } -> std::same_as<int>;
    { t.resolve(d, background, p, path) } -> std::same_as<Rgb<PlainDatapath>>;
    { t.resolve(cd, cbackground, cp, path) } -> std::same_as<Rgb<ChargedDatapath>>;
};

// A technique may keep one word a pixel that depends on its place only: std::uint32_t pixel_constant(int x,
// int y).
template <class T>
concept HasPixelConstant = requires(const T t) {
    { t.pixel_constant(0, 0) } -> std::same_as<std::uint32_t>;
};

template <Technique T>
class OperationOf : public FramebufferOperation {
 public:
    OperationOf(Parameters& parameters, const Screen& screen)
        : technique_(parameters, screen), screen_(screen) {}

    const Declaration& declaration() const override { return technique_.declaration(); }

    void run(int pass, std::span<const Fragment> fragments, std::span<const std::uint32_t> indices,
             PixelStore& store, OperationLog& log) const override {
        for (const std::uint32_t index : indices) {
            const Fragment& f = fragments[index];
            std::uint32_t* words = store.pixel(f.x, f.y);
            PixelAccess access{};
            PlainDatapath d;
            PlainPixel pixel(words, access, store.pool());
            const int path = technique_.fragment(d, pass, input<PlainDatapath>(f, words, store), pixel);
            log.add(path, access, d.step_count);
        }
    }

    void resolve(PixelStore& store, int tile_x, int tile_y, float* rgb, OperationLog& log) const override {
        for (int i = 0; i < kTilePixels; ++i) {
            const int x = tile_x * kTileSize + i % kTileSize;
            const int y = tile_y * kTileSize + i / kTileSize;
            if (x >= screen_.width || y >= screen_.height) continue;
            PixelAccess access{};
            PlainDatapath d;
            PlainPixel pixel(store.pixel(x, y), access, store.pool());
            const glm::vec3 bg = store.background(x, y);
            int path = 0;
            const Rgb<PlainDatapath> color = technique_.resolve(d, {bg.r, bg.g, bg.b}, pixel, path);
            write_color(color, rgb + std::ptrdiff_t{3} * i);
            if (!declaration().resolves) continue;  // the image is read where it lies: no operation, no bytes
            log.add(path, access, d.step_count);
            if (store.pool() != nullptr) {
                log.add_walk(pool_surface(), store.pool()->visited());
                store.pool()->visited().clear();
            }
        }
    }

    CostTable cost(const DatapathShape& shape) const override;
    ChargedOutcome charged_fragment(const DatapathShape& shape, int pass, const Fragment& fragment,
                                    PixelStore& store) const override;
    ChargedOutcome charged_resolve(const DatapathShape& shape, PixelStore& store, int x, int y,
                                   float* rgb) const override;

    std::function<std::uint32_t(int, int)> pixel_constant() const override {
        if constexpr (HasPixelConstant<T>)
            return [this](int x, int y) { return technique_.pixel_constant(x, y); };
        else
            return nullptr;
    }

 private:
    template <class D>
    FragmentInput<D> input(const Fragment& f, const std::uint32_t* words, const PixelStore& store) const {
        const float inverse_alpha = f.a > 0.0f ? 1.0f / f.a : 0.0f;
        FragmentInput<D> in{};
        in.z = f.z;
        in.a = f.a;
        in.premultiplied = {f.r, f.g, f.b};
        in.straight = {f.r * inverse_alpha, f.g * inverse_alpha, f.b * inverse_alpha};
        in.coverage = static_cast<std::uint32_t>(f.coverage);
        if constexpr (HasPixelConstant<T>) in.pixel_constant = words[store.constant_word()];
        if constexpr (requires { T::kRandom; }) {
            const std::uint64_t place =
                static_cast<std::uint64_t>(f.y) * static_cast<std::uint64_t>(screen_.width) + f.x;
            in.key =
                mix64(mix64(screen_.seed * 0x9E3779B97F4A7C15ull + f.draw) ^ (place << 32) ^ f.primitive);
        }
        return in;
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
            if (store.pool() != nullptr) store.pool()->allocate();  // a node for one step of a list
            PixelAccess access{};
            ChargedDatapath d(&script);
            const Ledger ledger(shape);
            std::uint32_t* words = store.pixel(0, 0);
            ChargedPixel pixel(words, access, store.pool(), /*worst=*/true);
            int path = 0;
            if (pass == kResolvePass) {
                technique_.resolve(d, {0.0f, 0.0f, 0.0f}, pixel, path);
            } else {
                const Fragment f{0.5f, 0.25f, 0.25f, 0.25f, 0.5f, 0, 0, 0, 0xFFFF, 0};
                path = technique_.fragment(d, pass, input<ChargedDatapath>(f, words, store), pixel);
            }
            add_path(table, shape, path, pass, ledger.work(), d, access);
        } while (detail::next_script(script));
    }
    for (std::size_t p = 0; p < table.size(); ++p)
        CHECK(!table[p].name.empty(), "path '{}' is never taken", declared.paths[p]);
    return table;
}

template <Technique T>
ChargedOutcome OperationOf<T>::charged_fragment(const DatapathShape& shape, int pass,
                                                const Fragment& fragment, PixelStore& store) const {
    ChargedOutcome outcome;
    const Ledger ledger(shape);
    ChargedDatapath d;
    std::uint32_t* words = store.pixel(fragment.x, fragment.y);
    ChargedPixel pixel(words, outcome.access, store.pool(), /*worst=*/false);
    outcome.path = technique_.fragment(d, pass, input<ChargedDatapath>(fragment, words, store), pixel);
    outcome.work = ledger.work();
    outcome.steps = d.step_count;
    outcome.step_work = d.step_work;
    return outcome;
}

template <Technique T>
ChargedOutcome OperationOf<T>::charged_resolve(const DatapathShape& shape, PixelStore& store, int x, int y,
                                               float* rgb) const {
    ChargedOutcome outcome;
    const Ledger ledger(shape);
    ChargedDatapath d;
    ChargedPixel pixel(store.pixel(x, y), outcome.access, store.pool(), /*worst=*/false);
    const glm::vec3 bg = store.background(x, y);
    const Rgb<ChargedDatapath> color = technique_.resolve(d, {bg.r, bg.g, bg.b}, pixel, outcome.path);
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
