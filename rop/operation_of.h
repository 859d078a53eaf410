// The adapter that turns a technique into a FramebufferOperation. What it does with costs is in
// rop/charged_operation.h.
#pragma once

#include "base/random.h"
#include "rop/operation.h"
#include "rop/technique_concept.h"
#include "traces/depth_test.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace ropsim {

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
            std::uint32_t* words = store.pixel(f.x, f.y);
            PixelAccess access;
            clear(access, many_surfaces);
            PlainDatapath d;
            PlainPixel pixel(words, access, store.pool());
            FragmentInput<PlainDatapath> in;
            const DepthSlope slope = fragments.slopes.empty() ? DepthSlope{} : fragments.slopes[index];
            set_input(in, pass, f, slope, round, words, store);
            if constexpr (HasShader<T>) put_exports(in, exported(pass, fragments, index, store));
            const int path = technique_.fragment(d, pass, in, pixel);
            log.add(path, access, d.step_count);
            if (log.keeps_values()) [[unlikely]]
                log.keep_values(words, access, store.pool());
        }
    }

    void image_pass(int pass, int, PixelStore& store, const StoreMap& stores, int tile_x, int tile_y,
                    OperationLog& log) const override {
        const Pass& declared = declaration().passes[static_cast<std::size_t>(pass)];
        if constexpr (HasGatherPass<T>) {
            if (declared.gathers) {
                for_gathering(store, stores, tile_x, tile_y, declared.scale, log,
                              [&](int, PlainDatapath& d, Gather<PlainPixel>& gather) {
                                  return technique_.gather_pass(d, pass, gather);
                              });
                return;
            }
        }
        for_pixels(tile_x, tile_y, declared.scale, [&](int, int x, int y) {
            PixelAccess access{};
            PlainDatapath d;
            PlainPixel pixel(store.pixel(x, y), access, store.pool());
            log.add(run_image_pass(d, pass, pixel), access, d.step_count);
        });
    }

    void resolve(PixelStore& store, const StoreMap& stores, int tile_x, int tile_y, float* rgb,
                 OperationLog& log) const override {
        if (declaration().footprint > 0) return resolve_tile_window(stores, tile_x, tile_y, rgb, log);
        if constexpr (HasGather<T>) {
            for_gathering(store, stores, tile_x, tile_y, 1, log,
                          [&](int i, PlainDatapath& d, Gather<PlainPixel>& gather) {
                              int path = 0;
                              write_color(technique_.resolve_gather(d, gather, path),
                                          rgb + std::ptrdiff_t{3} * i);
                              return path;
                          });
        } else {
            resolve_tile(store, tile_x, tile_y, rgb, log);
        }
    }

    CostTable cost(const DatapathShape& shape) const override;
    ChargedOutcome charged_fragment(const DatapathShape& shape, int pass, int round, const Fragment& fragment,
                                    const FragmentChannels& channels, PixelStore& store) const override;
    ChargedOutcome charged_image_pass(const DatapathShape& shape, int pass, int round, PixelStore& store,
                                      const StoreMap& stores, int x, int y) const override;
    ChargedOutcome charged_resolve(const DatapathShape& shape, PixelStore& store, const StoreMap& stores,
                                   int x, int y, float* rgb) const override;

    bool has_visibility() const override { return HasVisibility<T>; }
    void visibility([[maybe_unused]] PixelStore& store, [[maybe_unused]] int x, [[maybe_unused]] int y,
                    [[maybe_unused]] std::span<const float> depths,
                    [[maybe_unused]] std::span<float> values) const override {
        if constexpr (HasVisibility<T>) {
            PixelAccess access{};
            PlainPixel pixel(store.pixel(x, y), access, store.pool());
            technique_.visibility(pixel, depths, values);
            if (store.pool() != nullptr) store.pool()->visited().clear();
        } else {
            CHECK(false, "{} represents no visibility", T::kInfo.name);
        }
    }

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
    static constexpr std::size_t kFragmentPrefetch = 24;
    static constexpr std::size_t kPixelPrefetch = 10;

    // Calls body(number in the tile, x, y) for the tile's pixels inside the image of that scale, row by row.
    template <class Body>
    void for_pixels(int tile_x, int tile_y, int scale, Body body) const {
        const int width = low_resolution(screen_.width, scale);
        const int height = low_resolution(screen_.height, scale);
        for (int i = 0; i < kTilePixels; ++i) {
            const int x = tile_x * kTileSize + i % kTileSize;
            const int y = tile_y * kTileSize + i / kTileSize;
            if (x < width && y < height) body(i, x, y);
        }
    }
    // Calls body(number in the tile, datapath, gather), which returns the path taken, and logs the rest.
    template <class Body>
    void for_gathering(PixelStore& store, const StoreMap& stores, int tile_x, int tile_y, int scale,
                       OperationLog& log, Body body) const {
        GatherReads reads;
        reads.record = log.records_all();
        for_pixels(tile_x, tile_y, scale, [&](int i, int x, int y) {
            PixelAccess access{};
            PlainDatapath d;
            reads.clear();
            int path = 0;
            {
                Gather<PlainPixel> gather(stores, {store.pixel(x, y), access, store.pool()}, x, y, reads,
                                          false);
                path = body(i, d, gather);
            }
            log.add(path, access, d.step_count);
            log.add_gather(reads);
        });
    }
    template <class D, class P>
    int run_image_pass(D& d, int pass, P& pixel) const {
        if constexpr (HasImagePass<T>) {
            return technique_.image_pass(d, pass, pixel);
        } else {
            CHECK(false, "{} has no image passes", T::kInfo.name);
        }
    }
    template <class D>
    struct Resolved {
        Rgb<D> color;
        int path = 0;
    };
    // Which of the two a technique has is its declaration's word; the other is not there to be compiled.
    Resolved<ChargedDatapath> run_gather(ChargedDatapath& d, const StoreMap& stores,
                                         const ChargedPixel& pixel, int x, int y, bool worst) const {
        if constexpr (HasGather<T>) {
            Resolved<ChargedDatapath> out;
            GatherReads reads;
            Gather<ChargedPixel> gather(stores, pixel, x, y, reads, worst);
            out.color = technique_.resolve_gather(d, gather, out.path);
            return out;
        } else {
            CHECK(false, "{} does not gather", T::kInfo.name);
        }
    }
    template <class D, class P>
    Resolved<D> run_resolve(D& d, const PixelBackground& background, P& pixel) const {
        if constexpr (HasGather<T>) {
            CHECK(false, "{} gathers", T::kInfo.name);
        } else {
            Resolved<D> out;
            out.color = technique_.resolve(d, Background<D>(background), pixel, out.path);
            return out;
        }
    }
    int run_gather_pass(ChargedDatapath& d, int pass, const StoreMap& stores, const ChargedPixel& pixel,
                        int x, int y, bool worst) const {
        if constexpr (HasGatherPass<T>) {
            GatherReads reads;
            Gather<ChargedPixel> gather(stores, pixel, x, y, reads, worst);
            return technique_.gather_pass(d, pass, gather);
        } else {
            CHECK(false, "{} has no passes that gather", T::kInfo.name);
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
    void resolve_tile(PixelStore& store, int tile_x, int tile_y, float* rgb, OperationLog& log) const {
        for_pixels(tile_x, tile_y, 1, [&](int i, int x, int y) {
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
    void resolve_tile_window(const StoreMap& stores, int tile_x, int tile_y, float* rgb,
                             OperationLog& log) const {
        HaloTile halo(stores, tile_x, tile_y, declaration().footprint);
        const auto pixels =
            static_cast<std::uint64_t>(2 * halo.border + 1) * static_cast<std::uint64_t>(2 * halo.border + 1);
        for_pixels(tile_x, tile_y, 1, [&](int i, int, int) {
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
        return mix64(mix64(screen_.seed * 0x9E3779B97F4A7C15ull + f.draw) ^ (place << 32) ^
                     primitive_number(f));
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
        in.slope = slope;
        const auto positions = sample_positions(screen_.samples);
        for (std::size_t m = 0; m < positions.size(); ++m)
            in.sample_z[m] = sample_depth(f, slope, positions[m]);
    }
    template <class D>
    static void put_exports(FragmentInput<D>& in, const Exports& exports) {
        for (std::size_t i = 0; i < kMaxExports; ++i) in.exported[i] = exports[i];
    }
    Exports shaded(int pass, const Fragment& f, const Material& material, const PixelStore& store) const {
        const int scale = declaration().passes[static_cast<std::size_t>(pass)].scale;
        const int x = scale == 1 ? f.x : full_resolution(f.x, scale);
        const int y = scale == 1 ? f.y : full_resolution(f.y, scale);
        return technique_.shade(pass, {f, material, x, y, store.opaque_depth(x, y, 0)});
    }
    // What the shader exports for the fragment; with joined draws, for it and those before it that lie in its
    // registers.
    Exports exported(int pass, const FragmentSpan& span, std::size_t index, const PixelStore& store) const {
        const auto material = [&](std::size_t i) {
            return span.materials.empty() ? Material{} : span.materials[i];
        };
        const std::vector<std::uint8_t>& joined = declaration().joined_draws;
        const Fragment& last = span.fragments[index];
        if constexpr (HasJoin<T>) {
            if (!joined.empty() && joined[last.draw] != 0) {
                std::size_t first = index;
                while (first > 0 && joins(span.fragments[first - 1], last)) --first;
                Exports all = shaded(pass, span.fragments[first], material(first), store);
                for (std::size_t i = first + 1; i <= index; ++i)
                    all = technique_.joined(all, shaded(pass, span.fragments[i], material(i), store));
                return all;
            }
        }
        return shaded(pass, last, material(index), store);
    }
    void write_color(const Rgb<PlainDatapath>& color, float* rgb) const {
        const Format format = declaration().image_format;
        const auto stored = stored_rgb(format, std::array<float, 3>{color.r, color.g, color.b});
        // An accumulator of binary16 may have overflowed; a display takes infinity for its largest value.
        constexpr float kLargest = 65504.0f;
        std::ranges::transform(stored, rgb, [](float value) {
            return std::isinf(value) ? std::copysign(kLargest, value) : value;
        });
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

}  // namespace ropsim
