// Opacity shadow maps (Kim and Neumann 2001) and deep opacity maps (Yuksel and Keyser 2008) as transparency:
// OSMTF and OSMTV of Salvi et al. 2011, sections 4 and 4.1. K planes lie at uniform steps between a pixel's
// nearest and furthest fragment; a plane keeps the absorbance in front of it.
//
// What the papers leave open, or what is decided here. Plane k of K stands at (k + 1) / K of the bounds: one
// at the nearest fragment would always hold nothing, and the last one, at the furthest, holds what is in
// front of that. A fragment adds to the planes strictly behind it. `lookup=linear` interpolates absorbance
// between the planes at either side, as Kim and Neumann do, so that a fragment between two planes dims itself
// by a share of its own; `step` takes the plane in front. `sums=plane` keeps the sum at every plane: a
// fragment reads and writes all planes behind it, a look-up reads two. Which, is known once the bounds are: a
// fetch of its own, and fewer bytes than additive blending into fixed render targets, which moves them all.
// `sums=slab` keeps what is between two planes: a fragment writes one number, a look-up adds all in front.
// Total alpha is no matter of the map: the accumulator's alpha is the product of 1 - alpha.
//
// `planes=deep`: the planes reach `depth_range` (in units of the trace's depth) behind the nearest fragment,
// whose depth is all that the first pass keeps. `spacing=growing` makes the layers' sizes 1 : 2 : 3 ...,
// `equal` equal; between growing planes the look-up interpolates along the square root that numbers them.
// What lies behind the last plane counts to it, as Yuksel and Keyser recommend.
#include "rop/sampling/sample_means.h"
#include "rop/visibility/absorbance.h"
#include "rop/visibility/map_passes.h"

#include <fmt/format.h>

namespace ropsim {

class OpacityPlanes {
 public:
    static constexpr bool kAddressed = true;
    static constexpr bool kInRegisters = true;
    static constexpr bool kZeroAlphaHarmless = true;

    OpacityPlanes(Parameters& parameters, const MapOptions& options)
        : planes_(static_cast<int>(parameters.get_integer("slices", 16, 1, kMaxMapCells))),
          samples_(options.spatial_samples),
          variable_(options.memory == MapMemory::kVariable),
          nearest_only_(options.bounds == MapBounds::kNearest),
          growing_(parameters.get_choice("spacing", "equal", {"equal", "growing"}) == "growing"),
          linear_(parameters.get_choice("lookup", "linear", {"linear", "step"}) == "linear"),
          slabs_(parameters.get_choice("sums", "plane", {"plane", "slab"}) == "slab"),
          absorbance_(static_cast<float>(parameters.get_real("least_transmittance", 1e-5, 1e-9, 0.5))) {
        if (growing_ && !nearest_only_)
            throw UserError(parameters.where("spacing"),
                            "spacing=growing is of planes=deep: give that too, or leave spacing out");
        if (slabs_ && variable_)
            throw UserError(parameters.where("sums"),
                            "memory=variable keeps the map in registers, where sums=plane costs no bytes: "
                            "leave sums out");
        if (!variable_ && planes_ * samples_ > kMaxElements)
            throw UserError(
                parameters.has("slices") ? parameters.where("slices") : parameters.context(),
                fmt::format("{} slices for each of the trace's {} spatial samples are more than the {} "
                            "elements a pixel's surface has: take slices={} or memory=variable",
                            planes_, samples_, kMaxElements, kMaxElements / samples_));
    }
    void declare(Declaration& declaration, const TechniqueFormats& formats) {
        if (variable_) return;
        slices_ = declaration.surface(
            "slices", planes_ * samples_, Layout::kInterleaved, Initial::kClear,
            {FieldSpec::real(formats.of("slices", Format::kFloat32), 1, 0.0f, ValueRange::kSum)})[0];
    }

    // `index` planes lie in front of the fragment; `fraction` of the way to the next one it stands.
    template <class D>
    struct Place {
        typename D::Uint index;
        typename D::Real fraction;
    };
    template <class D>
    Place<D> place(const typename D::Real& share) const {
        using Real = typename D::Real;
        const auto count = static_cast<float>(planes_);
        Real position = share * Real(count);
        // Plane k stands at k (k + 1) / (K (K + 1)) of the range: the root of that is the position.
        if (growing_)
            position = (square_root(Real(1.0f) + share * Real(4.0f * count * (count + 1.0f))) - Real(1.0f)) *
                       Real(0.5f);
        const auto index = floor_to_uint(position);
        return {index, position - to_real(index)};
    }
    template <class D>
    typename D::Real amount(const typename D::Real& alpha) const {
        return absorbance_.of<D>(alpha);
    }

    template <class P>
    ElementCells<P> cells(P& pixel, int m) const {
        return {pixel, slices_, m * planes_};
    }
    template <class D, class P>
    void fetch_to_add(P& pixel, int m, const typename D::Bool& covered, const Place<D>& at) const {
        for (int k = first_behind(at); k < planes_; ++k)
            pixel.fetch_if(both(covered, wire<D>(taken<D>(at, k), at)), slices_, m * planes_ + k);
    }
    // With the decoder's lines that have already said what to fetch.
    template <class D, class Cells>
    void add(const Cells& cells, const typename D::Bool& covered, const Place<D>& at,
             const typename D::Real& amount) const {
        if (slabs_) return add_to_slab<D>(cells, covered, at, amount);
        for (int k = first_behind(at); k < planes_; ++k)
            cells.put_if(both(covered, takes<D>(at, k)), k, cells.load(k) + amount);
    }
    template <class D, class P>
    void fetch_to_look_up(P& pixel, int m, const typename D::Bool& covered, const Place<D>& at) const {
        for (int k = 0; k < planes_; ++k)
            pixel.fetch_if(both(covered, looked_at<D>(at, k)), slices_, m * planes_ + k);
    }
    template <class D, class Cells>
    typename D::Real visibility(const Cells& cells, const Place<D>& at) const {
        using Real = typename D::Real;
        const Real in_front = slabs_ ? sum_in_front<D>(cells, at) : plane<D>(cells, at, -1);
        if (!linear_) return exponential(negative(in_front));
        const Real next = plane<D>(cells, at, 0);
        const Real between = slabs_ ? next : next - in_front;
        return exponential(negative(in_front + at.fraction * between));
    }

 private:
    // Only planes from here on can take the fragment: a shortcut for values, all of them in hardware.
    int first_behind(const Place<PlainDatapath>& at) const {
        return std::min(static_cast<int>(at.index), planes_ - 1);
    }
    static int first_behind(const Place<ChargedDatapath>&) { return 0; }

    // A line of the decoder of a place's index: a gate each, or one that is there already.
    template <class D>
    static typename D::Bool line(bool value, const Place<D>& at) {
        if constexpr (D::kCharged)
            return {value, Ledger::active().charge(Unit::kLogic, at.index.ready)};
        else
            return value;
    }
    template <class D>
    static typename D::Bool wire(bool value, const Place<D>& at) {
        if constexpr (D::kCharged)
            return {value, at.index.ready};
        else
            return value;
    }
    // The first plane behind a fragment, or its slab. Behind a deep map's last plane it counts to that.
    template <class D>
    std::uint32_t first_plane(const Place<D>& at) const {
        const std::uint32_t index = value_of(at.index);
        return nearest_only_ ? std::min(index, static_cast<std::uint32_t>(planes_ - 1)) : index;
    }
    // Whether a fragment adds to plane k, or to slab k.
    template <class D>
    bool taken(const Place<D>& at, int k) const {
        const auto plane = static_cast<std::uint32_t>(k);
        return slabs_ ? plane == first_plane<D>(at) : plane >= first_plane<D>(at);
    }
    template <class D>
    typename D::Bool takes(const Place<D>& at, int k) const {
        return line<D>(taken<D>(at, k), at);
    }
    // One adder, between a selector of the slab and the write enables.
    template <class D, class Cells>
    void add_to_slab(const Cells& cells, const typename D::Bool& covered, const Place<D>& at,
                     const typename D::Real& amount) const {
        typename D::Real before = cells.load(
            static_cast<int>(std::min(first_plane<D>(at), static_cast<std::uint32_t>(planes_ - 1))));
        if constexpr (D::kCharged)
            before.ready = charge_selector(planes_, std::max(before.ready, at.index.ready));
        const auto sum = cells.storable_sum(before + amount);
        for (int k = first_behind(at); k < planes_; ++k)
            cells.write_if(both(covered, takes<D>(at, k)), k, sum);
    }
    // Whether a look-up reads plane k, or slab k.
    template <class D>
    typename D::Bool looked_at(const Place<D>& at, int k) const {
        const std::uint32_t index = value_of(at.index);
        const auto plane = static_cast<std::uint32_t>(k);
        const bool next = linear_ && plane == index;
        return line<D>(next || (slabs_ ? plane < index : plane + 1 == index), at);
    }
    // What the plane `offset` after the next one in front of the fragment holds: 0 in front of the first
    // plane and behind the last.
    template <class D, class Cells>
    typename D::Real plane(const Cells& cells, const Place<D>& at, int offset) const {
        using Real = typename D::Real;
        const int k = static_cast<int>(value_of(at.index)) + offset;
        const bool exists = k >= 0 && k < planes_;
        Real value = exists ? cells.load(k) : Real(0.0f);
        if constexpr (D::kCharged) {
            if (!exists) value = cells.load(0);
            value = {exists ? value.value : 0.0f,
                     charge_selector(planes_ + 1, std::max(value.ready, at.index.ready))};
        }
        return value;
    }
    template <class D, class Cells>
    typename D::Real sum_in_front(const Cells& cells, const Place<D>& at) const {
        using Real = typename D::Real;
        std::array<Real, kMaxElements> terms;
        for (int k = 0; k < planes_; ++k)
            terms[static_cast<std::size_t>(k)] = select(
                line<D>(static_cast<std::uint32_t>(k) < value_of(at.index), at), cells.load(k), Real(0.0f));
        return tree_sum(terms, planes_);
    }

    int planes_;
    int samples_;
    bool variable_;
    bool nearest_only_;
    bool growing_;
    bool linear_;
    bool slabs_;
    Absorbance absorbance_;
    Field slices_;
};

class OpacityMap : public MapPasses<OpacityPlanes> {
 public:
    static constexpr TechniqueInfo kInfo = {
        "opacity_map", "opacity shadow maps as transparency (Kim and Neumann 2001; Salvi et al. 2011)",
        "slices=16 (1..64), bounds=pixel|frame, planes=uniform|deep, spacing=equal|growing, "
        "depth_range=0.05 (1e-6 to 1), lookup=linear|step, sums=plane|slab, memory=fixed|variable, "
        "composite=plain|normalised, least_transmittance=1e-5 (1e-9 to 0.5)",
        false, ""};

    OpacityMap(Parameters& parameters, const Screen& screen)
        : MapPasses(parameters, opacity_map_options(parameters, screen)) {}

 private:
    static MapOptions opacity_map_options(Parameters& parameters, const Screen& screen) {
        MapOptions options = map_options(parameters, screen.samples, "plain");
        options.memory = map_memory(parameters);
        const bool deep = parameters.get_choice("planes", "uniform", {"uniform", "deep"}) == "deep";
        if (!deep) return options;
        if (options.bounds == MapBounds::kFrame)
            throw UserError(parameters.where("bounds"),
                            "planes=deep start at each pixel's nearest fragment: leave bounds=frame out");
        options.bounds = MapBounds::kNearest;
        options.depth_range = static_cast<float>(parameters.get_real("depth_range", 0.05, 1e-6, 1.0));
        return options;
    }
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(opacity_map, OpacityMap)
