// How much a fragment's depth counts in techniques that blend without order: the weights published for
// weighted blended OIT. McGuire and Bavoil 2013 number theirs; the rest are of the code that most programs
// copy.
//   eq7, eq8, eq9  the paper's, by distance |z| from the eye (known from public code that names them so:
//                  VisPy's and nvpro's). In metres here, by the camera of the trace; the paper tunes them for
//                  scenes of 0.1 to 500 units and names no unit
//   eq10           the paper's, by window depth (public code likewise)
//   blog2015       McGuire's article of March 2015 on implementing it, without the optional division by
//                  sqrt(|z|), as copies of that code with its comments have it: a factor of 1000 and a cap of
//                  300. As many copies have 10^8, which sits at the cap nearly everywhere
//   learnopengl    the tutorial's, the one most copied. For alpha above 0.031 it is 3000 at every depth
//   none           no depth: equations 5 and 6
#pragma once

#include "base/error.h"
#include "base/parameters.h"
#include "rop/datapath.h"
#include "rop/declaration.h"
#include "rop/operation.h"
#include "rop/view_distance.h"

#include <cstdint>
#include <string_view>

namespace ropsim {

class DepthWeight {
 public:
    // `name` is one of the above, the value of the caller's key `weight`. Throws UserError where the weight
    // goes by the distance from the eye and the trace's camera does not give it.
    DepthWeight(std::string_view name, const Parameters& parameters, const Screen& screen)
        : kind_(kind_of(name)) {
        if (kind_ == Kind::kEq7 || kind_ == Kind::kEq8 || kind_ == Kind::kEq9)
            distance_ = ViewDistance(screen.camera, parameters.where("weight"), "this weight",
                                     "use weight=eq10, blog2015, learnopengl or none");
    }

    // Of sums with these weights over the sum of weights times alpha, scaled to the total alpha: what is at
    // most the sum of alphas. Where no fragment weighs less than one without alpha, whatever the depths of
    // the two, the light of that one grows no brighter. (blog2015 ends at its least weight there; learnopengl
    // goes by depth: 100 in front, .1 behind.) Weights of 3000 at every depth end binary16 at 22 opaque
    // layers of any brightness, and white comes out.
    LightLaw light_law(Format sums) const {
        if (kind_ != Kind::kLearnOpenGl) return LightLaw::kMean;
        return sums == Format::kFloat16 ? LightLaw::kAdded : LightLaw::kScaled;
    }

    // The weight of a fragment of window depth `z`. `alpha` is what the paper calls so; what transmits in
    // colour gives its net coverage.
    template <class D>
    typename D::Real of(const typename D::Real& z, const typename D::Real& alpha) const {
        using Real = typename D::Real;
        switch (kind_) {
            case Kind::kEq7: {
                const Real z2 = square_of_distance<D>(z);
                return alpha *
                       clamped<D>(Real(10.0f) / (Real(1e-5f) + z2 * Real(1.0f / 25) + sixth_power<D>(z2)),
                                  3e3f);
            }
            case Kind::kEq8: {
                const Real distance = distance_.of<D>(z);
                const Real z2 = distance * distance;
                return alpha * clamped<D>(Real(10.0f) / (Real(1e-5f) + z2 * (distance * Real(1e-3f)) +
                                                         sixth_power<D>(z2)),
                                          3e3f);
            }
            case Kind::kEq9: {
                const Real q = square_of_distance<D>(z) * Real(1.0f / 40000);
                return alpha * clamped<D>(Real(0.03f) / (Real(1e-5f) + q * q), 3e3f);
            }
            case Kind::kEq10:
                return alpha * maximum(Real(0.01f), Real(3000.0f) * cube<D>(Real(1.0f) - z));
            case Kind::kBlog2015:
                return clamped<D>(
                    Real(1e3f) * cube<D>((alpha * Real(8.0f) + Real(0.01f)) * (Real(1.0f) - z * Real(0.95f))),
                    3e2f);
            case Kind::kLearnOpenGl:
                return clamped<D>(
                    Real(1e8f) * (cube<D>(minimum(Real(1.0f), alpha * Real(10.0f)) + Real(0.01f)) *
                                  cube<D>(Real(1.0f) - z * Real(0.9f))),
                    3e3f);
            case Kind::kNone:
                return Real(1.0f);
        }
        return Real(1.0f);
    }

 private:
    enum class Kind : std::uint8_t { kEq7, kEq8, kEq9, kEq10, kBlog2015, kLearnOpenGl, kNone };

    static Kind kind_of(std::string_view name) {
        if (name == "eq7") return Kind::kEq7;
        if (name == "eq8") return Kind::kEq8;
        if (name == "eq9") return Kind::kEq9;
        if (name == "eq10") return Kind::kEq10;
        if (name == "blog2015") return Kind::kBlog2015;
        if (name == "learnopengl") return Kind::kLearnOpenGl;
        CHECK(name == "none", "no such weight: {}", name);
        return Kind::kNone;
    }
    template <class D>
    typename D::Real square_of_distance(const typename D::Real& z) const {
        const auto distance = distance_.of<D>(z);
        return distance * distance;
    }
    // (|z| / 200)^6 of |z|^2.
    template <class D>
    static typename D::Real sixth_power(const typename D::Real& z2) {
        return cube<D>(z2 * typename D::Real(1.0f / 40000));
    }
    template <class D>
    static typename D::Real cube(const typename D::Real& x) {
        return x * x * x;
    }
    template <class D>
    static typename D::Real clamped(const typename D::Real& w, float most) {
        using Real = typename D::Real;
        return minimum(maximum(Real(0.01f), w), Real(most));
    }

    Kind kind_;
    ViewDistance distance_;
};

}  // namespace ropsim
