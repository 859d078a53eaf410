// Stochastic layered alpha blending: Wyman 2016, section 2.1 with equation 1 and continuous alphas, colour
// straight from the layers (the one-pass form). bits=inf is the k-buffer end of the paper's continuum. Left
// open by the paper and decided here: of equal depths the earlier arrival is nearer; bits=inf inserts always,
// which is the limit of equation 1 wherever anything behind the layers in front can still be seen.
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <array>
#include <cmath>
#include <vector>

namespace ropsim {

class Slab {
 public:
    static constexpr TechniqueInfo kInfo = {
        "slab", "stochastic layered alpha blending (Wyman 2016)",
        "layers=8 (1..64), bits=2*layers (1..256, or inf: the k-buffer end)", true, "layers=8,bits=16"};
    static constexpr bool kRandom = true;
    static constexpr int kMaxLayers = 64;
    static constexpr int kMaxBits = 256;

    Slab(Parameters& parameters, const Screen&)
        : layers_(static_cast<int>(parameters.get_integer("layers", 8, 1, kMaxLayers))),
          bits_(read_bits(parameters)) {
        const TechniqueFormats formats(parameters);
        const auto layer =
            declaration_.surface("layers", layers_, Layout::kInterleaved, Initial::kClear,
                                 {FieldSpec::real(formats.of("depth", Format::kFloat32), 1, kEmpty),
                                  FieldSpec::real(formats.of("color", Format::kUnorm8), 4, 0.0f)});
        depth_ = layer[0];
        color_ = layer[1];
        declaration_.passes = {{"insert", Shading::kFull}};
        declaration_.paths = {"behind_full_list", "insert", "resolve"};
        if (bits_ > 0) declaration_.paths.push_back("discard");
        declaration_.ordering = Ordering::kRaster;
        // With probabilities, alpha 0 is never inserted; the k-buffer would give it a layer.
        declaration_.zero_alpha_harmless = bits_ > 0;
        declaration_.random = bits_ > 0;
        declaration_.image_format = formats.image();
        if (bits_ > 0) fill_visible_table();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        using Bool = typename D::Bool;
        pixel.fetch_all(depth_, layers_);
        std::array<Bool, kMaxLayers> nearer;
        Bool all_nearer = false;  // layers are sorted: the last one tells
        for (int i = 0; i < layers_; ++i)
            all_nearer = nearer[static_cast<std::size_t>(i)] = pixel.load(depth_, i) <= f.z;
        if (d.decide(all_nearer)) return kBehindFullList;
        if (bits_ > 0) {
            const Real probability = insertion_probability<D>(f, pixel, nearer);
            if (d.decide(inverse(draw_unit<D>(f.key, 0) < probability))) return kDiscard;
        }
        shift_in<D>(f, pixel, nearer);
        return kInsert;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        using Real = typename D::Real;
        path = kResolve;
        pixel.fetch_all(depth_, layers_);
        Rgb<D> sum{0.0f, 0.0f, 0.0f};
        Real transmittance = 1.0f;
        for (int i = 0; i < layers_; ++i) {
            const Rgb<D> c = pixel.load_rgb(color_, i);
            sum = {sum.r + transmittance * c.r, sum.g + transmittance * c.g, sum.b + transmittance * c.b};
            transmittance = transmittance * (Real(1.0f) - pixel.load(color_, i, 3));
        }
        return {sum.r + transmittance * background.mean.r, sum.g + transmittance * background.mean.g,
                sum.b + transmittance * background.mean.b};
    }

 private:
    enum Path { kBehindFullList, kInsert, kResolve, kDiscard };
    static constexpr float kEmpty = 1e30f;  // depth of an unused layer; its alpha is 0

    // 0 stands for inf.
    int read_bits(Parameters& parameters) const {
        if (parameters.get_string("bits", std::to_string(2 * layers_)) == "inf") return 0;
        return static_cast<int>(parameters.get_integer("bits", std::int64_t{2} * layers_, 1, kMaxBits));
    }

    // Equation 1: P_b(s, t) = 1 - (s)_t / (b)_t, and 1 where t > s.
    void fill_visible_table() {
        const auto side = static_cast<std::size_t>(bits_) + 1;
        visible_.assign(side * side, 1.0f);
        for (int s = 0; s <= bits_; ++s) {
            double hidden = 1;
            for (int t = 0; t <= s; ++t) {
                visible_[static_cast<std::size_t>(s) * side + static_cast<std::size_t>(t)] =
                    static_cast<float>(1.0 - hidden);
                hidden *= static_cast<double>(s - t) / static_cast<double>(bits_ - t);
            }
        }
    }

    template <class D, class P>
    typename D::Real insertion_probability(const FragmentInput<D>& f, P& pixel,
                                           const std::array<typename D::Bool, kMaxLayers>& nearer) const {
        using Real = typename D::Real;
        // C_acc = 1 - product of (1 - alpha_i) over the layers in front: a tree of multipliers.
        std::array<Real, kMaxLayers> factor;
        for (int i = 0; i < layers_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            factor[k] = select(nearer[k], Real(1.0f) - pixel.load(color_, i, 3), Real(1.0f));
        }
        for (int stride = 1; stride < layers_; stride *= 2)
            for (int i = 0; i + stride < layers_; i += 2 * stride)
                factor[static_cast<std::size_t>(i)] =
                    factor[static_cast<std::size_t>(i)] * factor[static_cast<std::size_t>(i + stride)];
        const Real bits(static_cast<float>(bits_));
        const auto s = floor_to_uint(bits * (Real(1.0f) - factor[0]) + Real(0.5f));
        const auto t = floor_to_uint(bits * f.a + Real(0.5f));
        const std::size_t side = static_cast<std::size_t>(bits_) + 1;
        const float probability = visible_[static_cast<std::size_t>(value_of(s)) * side + value_of(t)];
        if constexpr (D::kCharged)
            return {probability, Ledger::active().charge(Unit::kTable, std::max(s.ready, t.ready))};
        else
            return probability;
    }

    // Every layer behind the fragment moves one place back, the furthest out of the list.
    template <class D, class P>
    void shift_in(const FragmentInput<D>& f, P& pixel,
                  const std::array<typename D::Bool, kMaxLayers>& nearer) const {
        for (int i = layers_ - 1; i >= 0; --i) {
            const auto k = static_cast<std::size_t>(i);
            // Layer i takes its predecessor when that stands behind the fragment too, else the fragment.
            const typename D::Bool takes_fragment = i == 0 ? typename D::Bool(true) : nearer[k - 1];
            const auto moved = [&](const auto& own, const auto& before, const auto& incoming) {
                return select(nearer[k], own, i == 0 ? incoming : select(takes_fragment, incoming, before));
            };
            const int before = std::max(i - 1, 0);
            const Rgb<D> own = pixel.load_rgb(color_, i);
            const Rgb<D> previous = pixel.load_rgb(color_, before);
            const auto z = moved(pixel.load(depth_, i), pixel.load(depth_, before), f.z);
            const auto alpha = moved(pixel.load(color_, i, 3), pixel.load(color_, before, 3), f.a);
            const Rgb<D> rgb = {moved(own.r, previous.r, f.premultiplied.r),
                                moved(own.g, previous.g, f.premultiplied.g),
                                moved(own.b, previous.b, f.premultiplied.b)};
            pixel.write_if(inverse(nearer[k]), depth_, i);
            pixel.put(depth_, i, 0, z);
            pixel.put_rgb(color_, i, rgb);
            pixel.put(color_, i, 3, alpha);
        }
    }

    int layers_;
    int bits_;
    std::vector<float> visible_;
    Declaration declaration_;
    Field depth_;
    Field color_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(slab, Slab)
