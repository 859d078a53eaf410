// Coloured stochastic shadow maps with caustics: McGuire and Mara 2017, section 4.3.3, after McGuire and
// Enderton 2011 as far as the former describes it. The trace is a light's view. The light's shader computes
// rho of each wavelength from alpha, transmission, index and normal (rop/shadow/caustics.h, which also says
// where the paper contradicts itself); the operation draws a number for each stored sample of each
// wavelength, and where it is below rho the depth test keeps the nearer depth. Look-ups, and the conversion
// to variance shadow maps, are in rop/shadow/.
//
// Decided here:
// * One depth surface a wavelength. Depths are fetched only where the draw was won: it needs nothing stored.
// * draws=separate gives each wavelength a draw of its own; with draws=shared a sample's wavelengths are won
//   or lost together as far as their rho allow, so that what is grey casts grey noise. The paper does not
//   say.
// * wavelengths=1 takes the mean of the transmissions ("a single map when the scene is known to have no
//   wavelength-varying transmission"); without materials rho is alpha.
// * samples=S is the paper's coin for each of S samples; the paper stores one.
// * A sample that kept nothing holds the opaque layer's depth, of which each wavelength takes a copy. The
//   paper says that opaque shadows have "a separate, leak-free Williams shadow map", not what the transparent
//   map starts from; empty=far is the far plane. Chebyshev's bound then loses most of what falls on opaque
//   receivers (docs/colored-shadows.md), which Figures 9 to 11 do not show.
// * The shader exports rho as it computes it, in 32 bits.

#include "rop/sampling/sample_mask.h"
#include "rop/shadow/colored_shadow_options.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

namespace ropsim {

class ColoredShadowMap {
 public:
    static constexpr TechniqueInfo kInfo = {
        "colored_shadow_map",
        "stochastic shadow map of a light's view for each wavelength, with caustics (McGuire and Mara 2017)",
        "wavelengths=3|1, samples=1 (1..64), caustics=on|off, caustics_sign=equations|prose, "
        "caustics_index=material|interface, draws=separate|shared, empty=opaque|far, "
        "seed_from=primitive|object"};
    static constexpr bool kRandom = true;

    ColoredShadowMap(Parameters& parameters, const Screen& screen)
        : options_(ColoredShadowOptions::read(parameters)),
          lights_(screen.camera, screen.width, screen.height),
          screen_(screen),
          shared_(parameters.get_choice("draws", "separate", {"separate", "shared"}) == "shared"),
          by_object_(parameters.get_choice("seed_from", "primitive", {"primitive", "object"}) == "object") {
        const TechniqueFormats formats(parameters);
        for (const std::string& name : options_.surfaces())
            depths_.push_back(declaration_.surface(
                name, options_.samples, Layout::kPlanar,
                options_.empty_is_opaque ? Initial::kOpaqueDepth : Initial::kClear,
                {FieldSpec::real(formats.of(name, Format::kFloat32), 1, 1.0f, ValueRange::kUnit)})[0]);
        declaration_.passes = {{"stochastic_depth", Shading::kAlphaOnly}};
        declaration_.paths = {"lost", "write"};
        declaration_.ordering = Ordering::kAny;
        declaration_.shades_materials = true;
        declaration_.added_shading.alu_instructions = shader_instructions();
        declaration_.random = true;
        declaration_.resolves = false;
        declaration_.image_is_color = false;
        declaration_.image_format = formats.image();
    }
    ColoredShadowMap(const ColoredShadowMap&) = delete;
    ColoredShadowMap& operator=(const ColoredShadowMap&) = delete;
    const Declaration& declaration() const { return declaration_; }

    std::uint64_t random_key(const Fragment& f) const {
        const std::uint64_t place =
            static_cast<std::uint64_t>(f.y) * static_cast<std::uint64_t>(screen_.width) + f.x;
        const std::uint64_t seed = screen_.seed * 0x9E3779B97F4A7C15ull;
        if (!by_object_) return mix64(mix64(seed + f.draw) ^ (place << 32) ^ primitive_number(f));
        const std::uint32_t object = f.draw < screen_.objects.size() ? screen_.objects[f.draw] : f.draw;
        return mix64(mix64(seed + (2ull << 32) + object) ^ (place << 32));
    }

    // rho of each wavelength.
    Exports shade(int, const ShadedFragment& f) const {
        const float incidence = options_.caustics.on ? lights_.incidence(f.fragment, f.material) : 1.0f;
        const std::array<float, 3> rho =
            options_.probability(f.fragment.a, f.material, incidence, faces_back(f.fragment));
        return {rho[0], rho[1], rho[2]};
    }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        const Wins<D> won = drawn(f);
        if (d.decide(inverse(any_won<D>(won)))) return kLost;
        for_each_depth(won, [&](const auto& wins, const Field& depth, int s) {
            pixel.fetch_if(wins.test(s), depth, s);
        });
        for_each_depth(won, [&](const auto& wins, const Field& depth, int s) {
            const auto z = pixel.as_stored(depth, f.z);
            const auto nearer = both(wins.test(s), z < pixel.load(depth, s));
            pixel.write_if(nearer, depth, s);
            pixel.put_if(nearer, depth, s, 0, z);
        });
        return kWrite;
    }

    // A map is read by look-ups, not shown.
    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P&, int& path) const {
        path = kLost;
        return background.mean;
    }

 private:
    enum Path { kLost, kWrite };
    template <class D>
    using Wins = std::array<SampleMask<D>, 3>;  // by wavelength

    // Scalar instructions of equations 12 and 13, s and its powers being constants of a material: n . w 3,
    // the power 3, the contrast 2, the factor 1; w towards a light at a finite distance 7 more. A wavelength
    // takes 1 - t, its product with alpha and that with the factor; the mean transmission 3.
    int shader_instructions() const {
        const bool caustics = options_.caustics.on;
        const int direction = lights_.parallel() ? 0 : 7;
        const int mean = options_.wavelengths == 1 ? 3 : 0;
        return (caustics ? 9 + direction : 0) + mean + options_.wavelengths * (caustics ? 3 : 2);
    }

    // Which stored samples the fragment is to shadow: those whose draw, in [0, 1), is below rho.
    template <class D>
    Wins<D> drawn(const FragmentInput<D>& f) const {
        Wins<D> won;
        for (int s = 0; s < options_.samples; ++s) {
            typename D::Real draw = 0.0f;
            for (int w = 0; w < options_.wavelengths; ++w) {
                if (w == 0 || !shared_)
                    draw = draw_unit<D>(f.key, static_cast<std::uint32_t>(w * options_.samples + s));
                set(won[static_cast<std::size_t>(w)], s, draw < f.exported[static_cast<std::size_t>(w)]);
            }
        }
        return won;
    }
    static void set(SampleMask<PlainDatapath>& mask, int s, bool value) {
        mask.bits |= static_cast<std::uint64_t>(value) << s;
    }
    static void set(SampleMask<ChargedDatapath>& mask, int s, const Wire<bool>& value) {
        mask.wires[static_cast<std::size_t>(s)] = value;
    }
    template <class D>
    typename D::Bool any_won(const Wins<D>& won) const {
        typename D::Bool any = any_sample(won[0], options_.samples);
        for (int w = 1; w < options_.wavelengths; ++w)
            any = either(any, any_sample(won[static_cast<std::size_t>(w)], options_.samples));
        return any;
    }
    template <class Wins, class Body>
    void for_each_depth(const Wins& won, Body body) const {
        for (std::size_t w = 0; w < depths_.size(); ++w)
            for_samples(won[w], options_.samples, [&](int s) { body(won[w], depths_[w], s); });
    }

    ColoredShadowOptions options_;
    LightDirections lights_;
    Screen screen_;
    bool shared_;
    bool by_object_;
    Declaration declaration_;
    std::vector<Field> depths_;  // by wavelength
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(colored_shadow_map, ColoredShadowMap)
