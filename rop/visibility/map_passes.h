// Transparency by a visibility map: Salvi et al. 2011, section 4. Passes over the geometry find the depths
// between which each pixel's map lies, add up the map, and composite every fragment by the visibility that
// the map gives it (equation 2). With memory=variable one pass captures lists and resolve walks them as often
// (section 4.1). The maps differ in what a fragment adds and how visibility is read: `Map` has
//   static constexpr bool kAddressed     what is fetched depends on where the fragment stands in the bounds
//   static constexpr bool kInRegisters   can be kept in registers: memory=variable
//   Map(Parameters&, MapOptions&); void declare(Declaration&, formats, options)
//   Place<D> place(share), amount<D>(alpha)
//   fetch_to_add / fetch_to_look_up (pixel, m, covered, place), cells(pixel, m)
//   add(cells, covered, place, amount), visibility<D>(cells, place)
// Over traces of M > 1 spatial samples everything of the fixed memory is kept M times (section 4.2); lists
// keep coverage masks, and resolve has M sets of registers. (The prototype shades M times instead, which
// walks the lists M times.)
#pragma once

#include "rop/lists/fragment_lists.h"
#include "rop/visibility/depth_bounds.h"
#include "rop/visibility/map_cells.h"
#include "rop/visibility/map_options.h"
#include "rop/visibility/visible_color.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace ropsim {

template <class Map>
class MapPasses {
 public:
    MapPasses(Parameters& parameters, const MapOptions& options)
        : options_(options), map_(parameters, options_) {
        const TechniqueFormats formats(parameters);
        declaration_.image_format = formats.image();
        declaration_.uses_coverage = true;
        declaration_.light = options_.normalised ? LightLaw::kScaled : LightLaw::kConserved;
        // A fragment of no effect widens the bounds.
        declaration_.zero_alpha_harmless = Map::kZeroAlphaHarmless && !options_.has_bounds();
        if (options_.memory == MapMemory::kVariable) {
            lists_ = FragmentLists(declaration_, formats, options_.spatial_samples);
            declaration_.passes = {{"append", Shading::kFull}};
            declaration_.paths = {"append", "overflow", "resolve"};
            declaration_.ordering = Ordering::kRaster;  // which fragments a full pool drops
        } else {
            declaration_.ordering = Ordering::kAny;
            if (options_.has_bounds()) {
                declaration_.passes.push_back({"bounds", Shading::kAlphaOnly});
                declaration_.paths = {"inside", "widen"};
            }
            declaration_.passes.push_back({"map", Shading::kAlphaOnly});
            declaration_.passes.push_back({"composite", Shading::kFull});
            for (const char* path : {"map", "composite", "resolve"}) declaration_.paths.emplace_back(path);
        }
        bounds_ = DepthBounds(declaration_, formats, options_);
        map_.declare(declaration_, formats);
        color_ = VisibleColor(declaration_, formats, options_);
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        if (options_.memory == MapMemory::kVariable) return lists_.append(d, f, pixel) ? 0 : 1;
        const int before = options_.has_bounds() ? 1 : 0;
        if (pass < before) return bounds_.template widen<D>(d, f, pixel) ? 1 : 0;
        if (pass == before)
            add<D>(f, pixel);
        else
            composite<D>(f, pixel);
        return pass + before;
    }

    template <class D, class P>
    Rgb<D> resolve(D& d, const Background<D>& background, P& pixel, int& path) const {
        path = static_cast<int>(declaration_.paths.size()) - 1;
        Sums<D> sums;
        if constexpr (Map::kInRegisters) {
            if (options_.memory == MapMemory::kVariable) {
                const std::vector<std::uint32_t>& nodes = lists_.walk(d, pixel);
                Registers registers = gathered(d, pixel, nodes);
                composite_list(d, pixel, nodes, registers, sums);
                return color_.template resolved<D>(background, sums);
            }
        }
        color_.fetch_all(pixel);
        for (int m = 0; m < samples(); ++m)
            sums[static_cast<std::size_t>(m)] = color_.template load<D>(pixel, m);
        return color_.template resolved<D>(background, sums);
    }

    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        PlainDatapath d;
        std::fill(values.begin(), values.end(), 0.0f);
        if constexpr (Map::kInRegisters) {
            if (options_.memory == MapMemory::kVariable) {
                Registers registers = gathered(d, pixel, lists_.walk(d, pixel));
                look_up(depths, values, [&](std::size_t m, float z) {
                    return map_.template visibility<PlainDatapath>(
                        RegisterCells<PlainDatapath>{registers.map[m]}, place(z, registers.range[m]));
                });
                return;
            }
        }
        look_up(depths, values, [&](std::size_t m, float z) {
            const auto range = bounds_.load<PlainDatapath>(pixel, static_cast<int>(m));
            return map_.template visibility<PlainDatapath>(map_.cells(pixel, static_cast<int>(m)),
                                                           place(z, range));
        });
    }

 private:
    template <class D>
    using Sums = std::array<VisibleSum<D>, kMaxSpatialSamples>;
    template <class D>
    using Places = std::array<typename Map::template Place<D>, kMaxSpatialSamples>;
    // What resolve keeps of a pixel while it walks a list. Plain numbers: a step finds them ready.
    struct Registers {
        std::array<DepthBounds::Range<PlainDatapath>, kMaxSpatialSamples> range;
        std::array<std::array<float, kMaxMapCells>, kMaxSpatialSamples> map{};
    };
    // Both kinds of step. The first traversal finds the bounds, the second the map: one pipe serves both.
    enum Step { kGatherStep, kCompositeStep };

    int samples() const { return options_.spatial_samples; }

    typename Map::template Place<PlainDatapath> place(float z,
                                                      const DepthBounds::Range<PlainDatapath>& range) const {
        return map_.template place<PlainDatapath>(
            bounds_.share<PlainDatapath>(std::clamp<float>(z, 0.0f, 1.0f), range));
    }
    // Means over the samples of visibility(sample, z).
    template <class Visibility>
    void look_up(std::span<const float> depths, std::span<float> values, Visibility visibility) const {
        for (std::size_t i = 0; i < depths.size(); ++i) {
            for (std::size_t m = 0; m < static_cast<std::size_t>(samples()); ++m)
                values[i] += visibility(m, depths[i]);
            values[i] /= static_cast<float>(samples());
        }
    }

    // Where the fragment stands in each sample's map. The bounds have been fetched.
    template <class D, class P>
    Places<D> places(const FragmentInput<D>& f, P& pixel) const {
        Places<D> found;
        for (int m = 0; m < samples(); ++m)
            found[static_cast<std::size_t>(m)] = map_.template place<D>(
                bounds_.template share<D>(f.depth_at(m), bounds_.template load<D>(pixel, m)));
        return found;
    }
    // Waits for the places where they say what is to be fetched and are known only from the bounds.
    template <class D, class P>
    void wait_for(const Places<D>& at, P& pixel) const {
        if (!options_.has_bounds()) return;
        if constexpr (Map::kAddressed && D::kCharged) {
            int ready = 0;
            for (int m = 0; m < samples(); ++m)
                ready = std::max(ready, at[static_cast<std::size_t>(m)].index.ready);
            pixel.next_fetch_stage(Wire<bool>(true, ready));
        }
    }

    template <class D, class P>
    void add(const FragmentInput<D>& f, P& pixel) const {
        bounds_.template fetch<D>(f, pixel);
        if constexpr (!Map::kAddressed)
            for (int m = 0; m < samples(); ++m) map_.fetch(pixel, m, bit(f.coverage, m));
        const Places<D> at = places<D>(f, pixel);
        wait_for<D>(at, pixel);
        if constexpr (Map::kAddressed)
            for (int m = 0; m < samples(); ++m)
                map_.template fetch_to_add<D>(pixel, m, bit(f.coverage, m), at[static_cast<std::size_t>(m)]);
        const auto amount = map_.template amount<D>(f.a);
        for (int m = 0; m < samples(); ++m)
            map_.template add<D>(map_.cells(pixel, m), bit(f.coverage, m), at[static_cast<std::size_t>(m)],
                                 amount);
    }

    template <class D, class P>
    void composite(const FragmentInput<D>& f, P& pixel) const {
        bounds_.template fetch<D>(f, pixel);
        color_.template fetch<D>(f, pixel);
        if constexpr (!Map::kAddressed)
            for (int m = 0; m < samples(); ++m) map_.fetch(pixel, m, bit(f.coverage, m));
        const Places<D> at = places<D>(f, pixel);
        wait_for<D>(at, pixel);
        if constexpr (Map::kAddressed)
            for (int m = 0; m < samples(); ++m)
                map_.template fetch_to_look_up<D>(pixel, m, bit(f.coverage, m),
                                                  at[static_cast<std::size_t>(m)]);
        for (int m = 0; m < samples(); ++m)
            color_.template add<D>(
                f, pixel, m,
                map_.template visibility<D>(map_.cells(pixel, m), at[static_cast<std::size_t>(m)]));
    }

    template <class D>
    void widen(Registers& registers, const FragmentLists::Node<D>& node, bool enabled) const {
        for (int m = 0; m < samples(); ++m) {
            auto& range = registers.range[static_cast<std::size_t>(m)];
            const auto nearest = minimum(typename D::Real(range.nearest), node.z);
            const auto furthest = options_.bounds == MapBounds::kPixel
                                      ? maximum(typename D::Real(range.furthest), node.z)
                                      : node.z;
            if (enabled && value_of(bit(node.coverage, m))) range = {value_of(nearest), value_of(furthest)};
        }
    }
    template <class D>
    typename Map::template Place<D> place_in(const Registers& registers, const typename D::Real& z,
                                             int m) const {
        const auto& range = registers.range[static_cast<std::size_t>(m)];
        const DepthBounds::Range<D> wires{range.nearest, range.furthest};
        return map_.template place<D>(bounds_.template share<D>(z, wires));
    }
    template <class D>
    void add(Registers& registers, const FragmentLists::Node<D>& node, bool enabled) const {
        const auto amount = map_.template amount<D>(node.a);
        for (int m = 0; m < samples(); ++m) {
            const typename D::Bool covered = enabled ? bit(node.coverage, m) : typename D::Bool(false);
            map_.template add<D>(RegisterCells<D>{registers.map[static_cast<std::size_t>(m)]}, covered,
                                 place_in<D>(registers, node.z, m), amount);
        }
    }
    // The traversals for bounds, which walk() has begun, and map.
    template <class D, class P>
    Registers gathered(D& d, P& pixel, const std::vector<std::uint32_t>& nodes) const {
        Registers registers;
        const auto count = static_cast<std::uint32_t>(nodes.size());
        const std::uint32_t first = options_.has_bounds() ? count : 0;
        if (options_.has_bounds()) FragmentLists::walk_again(pixel, nodes);
        if constexpr (D::kCharged) {
            d.steps(kGatherStep, first + count, [&](std::uint32_t i) {
                const auto node = lists_.read_without_color<D>(pixel, nodes, i < first ? i : i - first);
                if (options_.has_bounds()) widen<D>(registers, node, i < first);
                add<D>(registers, node, i >= first);
            });
        } else {
            d.count_steps(kGatherStep, first + count);
            for (std::uint32_t i = 0; i < first; ++i)
                widen<D>(registers, lists_.read_without_color<D>(pixel, nodes, i), true);
            for (std::uint32_t i = 0; i < count; ++i)
                add<D>(registers, lists_.read_without_color<D>(pixel, nodes, i), true);
        }
        return registers;
    }
    template <class D, class P>
    void composite_list(D& d, P& pixel, const std::vector<std::uint32_t>& nodes, Registers& registers,
                        Sums<D>& sums) const {
        FragmentLists::walk_again(pixel, nodes);
        d.steps(kCompositeStep, static_cast<std::uint32_t>(nodes.size()), [&](std::uint32_t i) {
            const auto node = lists_.read<D>(pixel, nodes, i);
            for (int m = 0; m < samples(); ++m) {
                const auto k = static_cast<std::size_t>(m);
                const auto visibility = map_.template visibility<D>(RegisterCells<D>{registers.map[k]},
                                                                    place_in<D>(registers, node.z, m));
                const VisibleSum<D> sum = VisibleColor::added<D>(registered(sums[k]), node.premultiplied,
                                                                 node.a, visibility, options_.normalised);
                if (value_of(bit(node.coverage, m))) sums[k] = registered(sum);
            }
        });
    }
    // As the next step finds it: ready.
    template <class D>
    static VisibleSum<D> registered(const VisibleSum<D>& sum) {
        return {{value_of(sum.color.r), value_of(sum.color.g), value_of(sum.color.b)},
                value_of(sum.weight),
                value_of(sum.transmittance)};
    }

    MapOptions options_;
    Map map_;
    Declaration declaration_;
    DepthBounds bounds_;
    VisibleColor color_;
    FragmentLists lists_;
};

}  // namespace ropsim
