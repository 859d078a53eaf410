// What a class must have to be a technique, and what it may have besides.
#pragma once

#include "rop/gather.h"
#include "rop/halo_window.h"
#include "rop/operation.h"
#include "rop/technique_input.h"

#include <concepts>
#include <cstdint>
#include <span>

namespace ropsim {

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
             ChargedDatapath cd, const FragmentInput<ChargedDatapath>& cf, ChargedPixel& cp) {
    { T::kInfo } -> std::convertible_to<TechniqueInfo>;
    { t.declaration() } -> std::convertible_to<const Declaration&>;
    { t.fragment(d, 0, f, p) } -> std::same_as<int>;
    { t.fragment(cd, 0, cf, cp) } -> std::same_as<int>;
} &&(
    requires(const T t, Gather<PlainPixel>& g, PlainDatapath d, int& path) {
        { t.resolve_gather(d, g, path) } -> std::same_as<Rgb<PlainDatapath>>;
    } ||
    requires(const T t, PlainDatapath d, PlainPixel& p, const Background<PlainDatapath>& background,
             int& path, ChargedDatapath cd, ChargedPixel& cp,
             const Background<ChargedDatapath>& cbackground) {
        { t.resolve(d, background, p, path) } -> std::same_as<Rgb<PlainDatapath>>;
        { t.resolve(cd, cbackground, cp, path) } -> std::same_as<Rgb<ChargedDatapath>>;
    });

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

// A technique whose fragments need more of their shader than depth, alpha and colour has
//   Exports shade(int pass, const ShadedFragment& f) const
// which is the shader's work, not the datapath's: the declaration states its cost, FragmentInput::exported
// its results.
template <class T>
concept HasShader = requires(const T t, const ShadedFragment& f) {
    { t.shade(0, f) } -> std::same_as<Exports>;
};

template <class T>
concept HasImagePass = requires(const T t, PlainDatapath d, PlainPixel& p) {
    { t.image_pass(d, 0, p) } -> std::same_as<int>;
};

// A technique that represents visibility can be asked for it once its passes have run:
//   void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const
// the transmittance in front of each depth, a mean over the pixel's spatial samples, as the composite would
// take it for a fragment at that depth.
template <class T>
concept HasVisibility = requires(const T t, PlainPixel& p, std::span<const float> depths,
                                 std::span<float> values) {
    { t.visibility(p, depths, values) } -> std::same_as<void>;
};

// Of a shader: what the fragments of a draw that the declaration joins export together, `first` drawn before
// `second`.
//   Exports joined(const Exports& first, const Exports& second) const
template <class T>
concept HasJoin = requires(const T t, const Exports& e) {
    { t.joined(e, e) } -> std::same_as<Exports>;
};

// Of a technique whose declaration says that it gathers, instead of resolve; and image passes that do.
//   Rgb<D> resolve_gather(D& d, Gather<P>& gather, int& path) const
//   int gather_pass(D& d, int pass, Gather<P>& gather) const
template <class T>
concept HasGather = requires(const T t, PlainDatapath d, Gather<PlainPixel>& g, int& path) {
    { t.resolve_gather(d, g, path) } -> std::same_as<Rgb<PlainDatapath>>;
};
template <class T>
concept HasGatherPass = requires(const T t, PlainDatapath d, Gather<PlainPixel>& g) {
    { t.gather_pass(d, 0, g) } -> std::same_as<int>;
};

template <class T>
concept HasWindow = requires(const T t, PlainDatapath d, Window<PlainPixel>& w, int& path) {
    { t.resolve_window(d, w, path) } -> std::same_as<Rgb<PlainDatapath>>;
};

}  // namespace ropsim
