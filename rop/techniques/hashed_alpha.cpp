// Hashed alpha testing: Wyman and McGuire 2017 ("Hashed Alpha Testing", section 3). One opaque sample a
// pixel; a fragment passes when its alpha reaches a threshold hashed from where it is, so that the noise
// stays on the surface while the view does. With `hash=position` space is cut into cubes of about a pixel's
// size at the fragment's depth. Sizes are powers of two; the hashes of the next coarser and finer cubes are
// blended, and the blend's distribution function makes the threshold uniform again.
//
// Deviations. A trace has no object space: positions are the world's, through the trace's camera, so that
// moving objects leave their noise behind. The pixel's size is that of a surface that faces the camera, not
// stretched by the surface's slope. The hash is of integers (the paper's, of sines, is another one on every
// machine), and the blend runs with the scale's mantissa instead of its logarithm: the same ends, a uniform
// threshold all the same. Other choices, for traces without a camera and for comparison: `hash=pixel` hashes
// pixel and depth, `hash=primitive` pixel, draw call and primitive. The seed shifts all three.
#include "rop/sample_mean.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"
#include "rop/threshold_hash.h"

#include <optional>
#include <string>

namespace ropsim {

class HashedAlpha {
 public:
    static constexpr TechniqueInfo kInfo = {"hashed_alpha", "hashed alpha testing (Wyman and McGuire 2017)",
                                            "hash=position|pixel|primitive", false, ""};
    static constexpr bool kRandom = true;

    HashedAlpha(Parameters& parameters, const Screen& screen)
        : samples_(screen.samples), seed_(static_cast<std::uint32_t>(mix64(screen.seed))) {
        const std::string hash = parameters.get_choice("hash", screen.camera ? "position" : "pixel",
                                                       {"position", "pixel", "primitive"});
        by_primitive_ = hash == "primitive";
        if (hash == "position") {
            if (!screen.camera)
                throw UserError(
                    parameters.where("hash"),
                    "hashes positions in the world, and the trace has no camera; use hash=pixel, or "
                    "capture with ropsim capture or ropsim_trace_set_camera()");
            cubes_.emplace(screen.width, screen.height, *screen.camera);
            if (!cubes_->valid())
                throw UserError(
                    parameters.has("hash") ? parameters.where("hash") : "--technique hashed_alpha",
                    "hashes positions in the world, and the matrices of the trace's camera have no "
                    "inverse; use hash=pixel");
        }
        const TechniqueFormats formats(parameters);
        depth_ = declaration_.surface(
            "depth", samples_, Layout::kPlanar, Initial::kOpaqueDepth,
            {FieldSpec::real(formats.of("depth", Format::kFloat32), 1, 1.0f, ValueRange::kUnit)})[0];
        color_ = declaration_.surface(
            "color", samples_, Layout::kPlanar, Initial::kOpaqueColor,
            {FieldSpec::real(formats.rgb("color", Format::kUnorm8), 4, 1.0f, ValueRange::kColor)})[0];
        declaration_.passes = {{"draw", Shading::kFull}};
        declaration_.paths = {"rejected", "passed", "resolve"};
        declaration_.ordering = Ordering::kAny;
        declaration_.uses_coverage = true;
        declaration_.random = true;
        declaration_.resolve_reads_background = false;
        declaration_.image_format = formats.image();
        declaration_.light = LightLaw::kMean;  // of one fragment
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        const typename D::Real reference = threshold(f);
        if (d.decide(f.a < reference)) return kRejected;
        for (int m = 0; m < samples_; ++m) pixel.fetch_if(bit(f.coverage, m), depth_, m);
        for (int m = 0; m < samples_; ++m) {
            const auto z = pixel.as_stored(depth_, f.depth_at(m));
            const auto pass = both(bit(f.coverage, m), z < pixel.load(depth_, m));
            pixel.write_if(pass, depth_, m);
            pixel.write_if(pass, color_, m);
            pixel.put_if(pass, depth_, m, 0, z);
            pixel.put_rgb_if(pass, color_, m, f.straight());
        }
        return kPassed;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>&, P& pixel, int& path) const {
        path = kResolve;
        pixel.fetch_all(color_, samples_);
        return mean_of_samples<D>(pixel, color_, samples_);
    }

 private:
    enum Path { kRejected, kPassed, kResolve };

    // In (0, 1], uniform.
    template <class D>
    typename D::Real threshold(const FragmentInput<D>& f) const {
        using Uint = typename D::Uint;
        if (by_primitive_) return hashed_unit<D>(draw_bits<D>(f.key, 0));
        if (!cubes_) {
            const Uint place(static_cast<std::uint32_t>(f.x) | static_cast<std::uint32_t>(f.y) << 16);
            return hashed_unit<D>(hash_words<D>({place, stored_word(value_of(f.z)), Uint(0u)}, seed_));
        }
        return cube_threshold<D>(cubes_->at(f.x, f.y, value_of(f.z)), seed_);
    }

    int samples_;
    std::uint32_t seed_;
    bool by_primitive_ = false;
    std::optional<PixelCubes> cubes_;
    Declaration declaration_;
    Field depth_;
    Field color_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(hashed_alpha, HashedAlpha)
