// k+-buffer: Vasilakis and Fudos 2014, the max-array form: a pixel's k nearest fragments in no order but that
// slot 0 holds the furthest once all slots are full, and a count. A fragment that is not nearer than slot 0
// is culled there; until then fragments go into slots k - 1 downwards; later ones replace the furthest, and
// the furthest of all others takes its place. Sorted at the end. As an operation: slot 0 and the count are
// one fetch stage, the other slots a second one that only fragments in front of slot 0 with a full array (or
// the one that fills it) come to. The paper's semaphore a pixel does not exist where operations on a pixel
// are atomic. Decided here: of equal depths the earlier arrival is nearer as long as none has been replaced;
// after that the array does not know which came first, and the higher slot is nearer.
#include "rop/nodes/stored_layers.h"
#include "rop/sampling/sorting_network.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <array>
#include <bit>
#include <cstdint>
#include <span>

namespace ropsim {

class KPlusBuffer {
 public:
    static constexpr TechniqueInfo kInfo = {
        "k_plus_buffer", "k+-buffer, max-array (Vasilakis and Fudos 2014)", "layers=8 (2..64)", false, ""};

    KPlusBuffer(Parameters& parameters, const Screen&)
        : slot_count_(static_cast<int>(parameters.get_integer("layers", 8, 2, kMaxNodes))) {
        const TechniqueFormats formats(parameters);
        slots_ = {declaration_, formats, slot_count_, {}};
        declaration_.surfaces.back().addressed = true;
        count_ = declaration_.surface("count", 1, Layout::kInterleaved, Initial::kClear,
                                      {FieldSpec::integer(32, 0)})[0];
        declaration_.passes = {{"insert", Shading::kFull}};
        declaration_.paths = {"culled", "append", "fill", "replace", "resolve"};
        declaration_.ordering = Ordering::kAny;
        declaration_.zero_alpha_harmless = false;  // it takes a slot
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        using Bool = typename D::Bool;
        using Uint = typename D::Uint;
        slots_.fetch_first(pixel);
        pixel.fetch_all(count_, 1);
        // Unused, slot 0 is farther than everything.
        const Bool in_front = slots_.stored_depth<D>(pixel, f.z) < slots_.depth(pixel, 0);
        if (d.decide(inverse(in_front))) return kCulled;
        const auto incoming = slots_.converted<D>(pixel, f.z, f.premultiplied, f.a, {0u, 0u});
        const Uint count = pixel.load_bits(count_);
        const Uint last(static_cast<std::uint32_t>(slot_count_ - 1));
        if (d.decide(count < last)) {
            slots_.put<D>(pixel, static_cast<int>(value_of(last - count)), incoming);
            put_count(pixel, count + Uint(1u));
            return kAppend;
        }
        const Bool fills = count == last;
        pixel.next_fetch_stage(fills);
        slots_.fetch(pixel);
        if (d.decide(fills)) {
            replace_furthest<D>(pixel, incoming);
            put_count(pixel, count + Uint(1u));
            return kFill;
        }
        replace_furthest<D>(pixel, incoming);
        return kReplace;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        using Real = typename D::Real;
        path = kResolve;
        slots_.fetch(pixel);
        // Slots in reverse: the earlier of equal depths stands in the higher slot.
        const auto all = mask_at<D>(low_bits(static_cast<std::uint32_t>(slot_count_)), 0);
        const auto order = sorted_samples(all, slot_count_, true,
                                          [&](int i) { return slots_.depth(pixel, slot_count_ - 1 - i); });
        Rgb<D> sum{0.0f, 0.0f, 0.0f};
        Real transmittance = 1.0f;
        for (int i = 0; i < slot_count_; ++i) {
            const auto& sorted = order.sample[static_cast<std::size_t>(i)];
            const int slot = slot_count_ - 1 - static_cast<int>(value_of(sorted));
            Rgb<D> c = slots_.color(pixel, slot);
            Real a = slots_.alpha(pixel, slot);
            if constexpr (D::kCharged)
                c.r.ready = c.g.ready = c.b.ready = a.ready = selected(sorted, a.ready);
            sum = {sum.r + transmittance * c.r, sum.g + transmittance * c.g, sum.b + transmittance * c.b};
            transmittance = transmittance * (Real(1.0f) - a);
        }
        return {sum.r + transmittance * background.mean.r, sum.g + transmittance * background.mean.g,
                sum.b + transmittance * background.mean.b};
    }

    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        for (std::size_t i = 0; i < depths.size(); ++i) {
            values[i] = 1.0f;
            const float z = slots_.stored_depth<PlainDatapath>(pixel, depths[i]);
            for (int slot = 0; slot < slot_count_; ++slot)
                if (slots_.depth(pixel, slot) < z) values[i] *= 1.0f - slots_.alpha(pixel, slot);
        }
    }

 private:
    enum Path { kCulled, kAppend, kFill, kReplace, kResolve };

    template <class P, class U>
    void put_count(P& pixel, const U& count) const {
        pixel.write(count_);
        pixel.put_bits(count_, 0, 0, count);
    }

    // The furthest of slots 1..k-1 and the fragment goes to slot 0, of equal depths the fragment; if it is
    // not the fragment, the fragment takes its slot. A tree of comparators that keeps the lower slot.
    template <class D, class P>
    void replace_furthest(P& pixel, const StoredLayers::Layer<D>& incoming) const {
        using Real = typename D::Real;
        using Uint = typename D::Uint;
        std::array<Real, kMaxNodes> depth;
        std::array<Uint, kMaxNodes> slot;
        for (int i = 1; i < slot_count_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            depth[k - 1] = slots_.depth(pixel, i);
            slot[k - 1] = static_cast<std::uint32_t>(i);
        }
        for (int count = slot_count_ - 1; count > 1; count = (count + 1) / 2) {
            for (int i = 0; i + 1 < count; i += 2) {
                const auto a = static_cast<std::size_t>(i);
                const auto further = depth[a] < depth[a + 1];
                depth[a / 2] = select(further, depth[a + 1], depth[a]);
                slot[a / 2] = select(further, slot[a + 1], slot[a]);
            }
            if (count % 2 == 1) {
                depth[static_cast<std::size_t>(count / 2)] = depth[static_cast<std::size_t>(count - 1)];
                slot[static_cast<std::size_t>(count / 2)] = slot[static_cast<std::size_t>(count - 1)];
            }
        }
        const int furthest = static_cast<int>(value_of(slot[0]));
        const auto nearer = slots_.depth<D>(incoming) < depth[0];
        StoredLayers::Layer<D> old = slots_.read<D>(pixel, furthest);
        if constexpr (D::kCharged) {
            const int ready = selected(slot[0], 0);
            for (auto& word : old.words) word.ready = ready;
        }
        slots_.put<D>(pixel, 0, slots_.chosen(nearer, old, incoming));
        slots_.put_if<D>(pixel, nearer, furthest, incoming);
    }
    // A slot's colour and alpha out of k: a selector for each word as stored.
    int selected(const Wire<std::uint32_t>& index, int data_ready) const {
        int done = 0;
        for (int w = 0; w < slots_.color_words(); ++w)
            done = charge_selector(slot_count_, std::max(index.ready, data_ready));
        return done;
    }

    int slot_count_;
    StoredLayers slots_;
    Declaration declaration_;
    Field count_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(k_plus_buffer, KPlusBuffer)
