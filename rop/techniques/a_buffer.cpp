// A-buffer: Carpenter 1984, as per-pixel linked lists on a GPU (Yang et al. 2010), the two references of
// Salvi et al. 2011, section 5.3. `resolve=recursive` (equation 3) sorts the pixel's list by depth and
// composites front to back; `iterative` (equation 2) needs no sorter: for each fragment it walks the whole
// list again and multiplies what is in front, n (n + 1) nodes read. Of equal depths the earlier arrival is
// nearer in both, known from the place in the list. (Equation 4 taken at its word would let fragments of
// equal depth not dim each other.)
//
// A node is read once a walk and waits whole in the resolve engine's buffer, which no size bounds here; of
// the sort its comparisons are charged, a binary insertion's.
//
// A full pool drops fragments and counts them, or blends them in order of arrival into one more colour a
// pixel, behind everything in its list (`overflow=blend_tail`). Over traces of M > 1 spatial samples resolve
// composites M times side by side, with the fragments whose coverage mask says so; one list serves all, where
// shading at sample rate (section 4.2) would walk it M times.
#include "rop/lists/fragment_lists.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <vector>

namespace ropsim {

class ABuffer {
 public:
    static constexpr TechniqueInfo kInfo = {
        "a_buffer", "A-buffer of per-pixel lists, sorted at resolve (Carpenter 1984)",
        "resolve=recursive|iterative, overflow=drop|blend_tail", true, ""};

    ABuffer(Parameters& parameters, const Screen& screen)
        : samples_(screen.samples),
          iterative_(parameters.get_choice("resolve", "recursive", {"recursive", "iterative"}) ==
                     "iterative"),
          has_tail_(parameters.get_choice("overflow", "drop", {"drop", "blend_tail"}) == "blend_tail") {
        const TechniqueFormats formats(parameters);
        lists_ = FragmentLists(declaration_, formats, samples_);
        if (has_tail_) {
            const auto fields = declaration_.surface(
                "tail", samples_, Layout::kInterleaved, Initial::kClear,
                {FieldSpec::real(formats.of("tail", Format::kFloat16), 3, 0.0f, ValueRange::kColor),
                 FieldSpec::real(formats.of("tail", Format::kFloat16), 1, 1.0f, ValueRange::kUnit)});
            tail_color_ = fields[0];
            tail_transmittance_ = fields[1];
        }
        declaration_.passes = {{"append", Shading::kFull}};
        declaration_.paths = {"append", "overflow", "resolve"};
        declaration_.ordering = Ordering::kRaster;
        declaration_.uses_coverage = true;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        if (lists_.append(d, f, pixel)) return kAppend;
        if (has_tail_) blend_tail<D>(f, pixel);
        return kOverflow;
    }

    // Recursive: a step a node (fetch and composite), and one a comparison of the sort. Iterative: a step a
    // node, and one a node of each walk.
    template <class D, class P>
    Rgb<D> resolve(D& d, const Background<D>& background, P& pixel, int& path) const {
        path = kResolve;
        if (has_tail_) pixel.fetch_all(tail_color_, samples_);
        const std::vector<std::uint32_t>& nodes = lists_.walk(d, pixel);
        std::vector<Entry>& list = scratch();
        list.clear();
        for (std::uint32_t i = 0; i < nodes.size(); ++i) list.push_back({lists_.depth(pixel, nodes, i), i});
        Sums sums;
        if (iterative_) {
            sum_iteratively(d, pixel, nodes, list, sums);
        } else {
            sort(d, list);
            composite(d, pixel, nodes, list, sums);
        }
        return over_background<D>(background, pixel, sums);
    }

    // The product of 1 - alpha of what is strictly in front.
    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        const PlainDatapath d;
        const std::vector<std::uint32_t>& nodes = lists_.walk(d, pixel);
        for (std::size_t i = 0; i < depths.size(); ++i) {
            std::array<float, kMaxSpatialSamples> product;
            product.fill(1.0f);
            for (std::uint32_t n = 0; n < nodes.size(); ++n) {
                const auto node = lists_.read_without_color<PlainDatapath>(pixel, nodes, n);
                if (!(node.z < depths[i])) continue;
                for (int m = 0; m < samples_; ++m)
                    if (bit(node.coverage, m)) product[static_cast<std::size_t>(m)] *= 1.0f - node.a;
            }
            values[i] = 0.0f;
            for (int m = 0; m < samples_; ++m) values[i] += product[static_cast<std::size_t>(m)];
            values[i] /= static_cast<float>(samples_);
        }
    }

 private:
    enum Path { kAppend, kOverflow, kResolve };
    enum Step { kNodeStep, kListStep };  // kListStep: of the sort, or of a walk
    // What the sorter compares; the rest of a node waits in the resolve engine's buffer.
    struct Entry {
        float z = 0;
        std::uint32_t position = 0;  // in the list: later arrivals come first

        bool in_front_of(const Entry& other) const {
            return z < other.z || (z == other.z && position > other.position);
        }
    };
    // Of each spatial sample, in registers: a step finds them ready.
    struct Sums {
        std::array<std::array<float, 3>, kMaxSpatialSamples> color{};
        std::array<float, kMaxSpatialSamples> transmittance;
        Sums() { transmittance.fill(1.0f); }
    };

    static std::vector<Entry>& scratch() {
        static thread_local std::vector<Entry> list;
        return list;
    }

    // The pool's answer is known now, the tail's bytes are asked for after it.
    template <class D, class P>
    void blend_tail(const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        using Bool = typename D::Bool;
        pixel.next_fetch_stage(Bool(true));
        const Real t = Real(1.0f) - f.a;
        for (int m = 0; m < samples_; ++m) pixel.fetch_if(bit(f.coverage, m), tail_color_, m);
        for (int m = 0; m < samples_; ++m) {
            const Bool covered = bit(f.coverage, m);
            const Rgb<D> tail = pixel.load_rgb(tail_color_, m);
            const Real transmittance = pixel.load(tail_transmittance_, m);
            pixel.write_if(covered, tail_color_, m);
            const Rgb<D> blended = {f.premultiplied.r + t * tail.r, f.premultiplied.g + t * tail.g,
                                    f.premultiplied.b + t * tail.b};
            pixel.put_rgb_if(covered, tail_color_, m, saturated(tail_color_, blended));
            pixel.put_if(covered, tail_transmittance_, m, 0, transmittance * t);
        }
    }

    // Comparisons of a binary insertion sort of n entries, whatever their values: the steps hardware is
    // charged for.
    static std::uint32_t sort_steps(std::size_t n) {
        std::uint32_t steps = 0;
        for (std::size_t i = 1; i < n; ++i) steps += static_cast<std::uint32_t>(std::bit_width(i));
        return steps;
    }
    template <class D>
    void sort(D& d, std::vector<Entry>& list) const {
        std::sort(list.begin(), list.end(), [](const Entry& a, const Entry& b) { return a.in_front_of(b); });
        const std::uint32_t steps = sort_steps(list.size());
        if constexpr (D::kCharged) {
            d.steps(kListStep, steps, [](std::uint32_t) {
                const auto nearer = Wire<float>(0.0f) < Wire<float>(1.0f);
                select(nearer, Wire<std::uint32_t>(0u), Wire<std::uint32_t>(1u));
            });
        } else {
            d.count_steps(kListStep, steps);
        }
    }

    // Adds a node to sample m under visibility v. Of a node that does not cover it, nothing.
    template <class D, class Node>
    static void add(const Node& node, int m, const typename D::Real& v, Sums& sums) {
        using Real = typename D::Real;
        const auto k = static_cast<std::size_t>(m);
        const Rgb<D> sum = {Real(sums.color[k][0]) + v * node.premultiplied.r,
                            Real(sums.color[k][1]) + v * node.premultiplied.g,
                            Real(sums.color[k][2]) + v * node.premultiplied.b};
        const Real transmittance = Real(sums.transmittance[k]) * (Real(1.0f) - node.a);
        if (!value_of(bit(node.coverage, m))) return;
        sums.color[k] = {value_of(sum.r), value_of(sum.g), value_of(sum.b)};
        sums.transmittance[k] = value_of(transmittance);
    }

    // Front to back: each node adds its colour under the transmittance in front of it.
    template <class D, class P>
    void composite(D& d, P& pixel, const std::vector<std::uint32_t>& nodes, const std::vector<Entry>& list,
                   Sums& sums) const {
        d.steps(kNodeStep, static_cast<std::uint32_t>(list.size()), [&](std::uint32_t i) {
            const auto node = lists_.read<D>(pixel, nodes, i < list.size() ? list[i].position : i);
            for (int m = 0; m < samples_; ++m)
                add<D>(node, m, typename D::Real(sums.transmittance[static_cast<std::size_t>(m)]), sums);
        });
    }

    // In order of arrival, latest first: each node under the product over the whole list.
    template <class D, class P>
    void sum_iteratively(D& d, P& pixel, const std::vector<std::uint32_t>& nodes,
                         const std::vector<Entry>& list, Sums& sums) const {
        const auto count = static_cast<std::uint32_t>(list.size());
        std::array<float, kMaxSpatialSamples> visible;
        visible.fill(1.0f);
        const auto multiply = [&](std::uint32_t j, const Entry& at) {
            using Real = typename D::Real;
            const auto node = lists_.read_without_color<D>(pixel, nodes, j);
            const Entry other = j < count ? list[j] : Entry{};
            const auto in_front = is_in_front<D>(other, at);
            const Real t = Real(1.0f) - node.a;
            for (int m = 0; m < samples_; ++m) {
                float& v = visible[static_cast<std::size_t>(m)];
                const Real product = Real(v) * t;
                v = value_of(select(both(bit(node.coverage, m), in_front), product, Real(v)));
            }
        };
        for (std::uint32_t i = 0; i < count; ++i) {
            FragmentLists::walk_again(pixel, nodes);
            visible.fill(1.0f);
            d.steps(kListStep, count, [&](std::uint32_t j) { multiply(j, list[i]); });
            d.steps(kNodeStep, 1, [&](std::uint32_t) { add_visible<D>(pixel, nodes, i, visible, sums); });
        }
        // While control paths are enumerated there is no list: a step of each kind all the same.
        if (count == 0) {
            d.steps(kListStep, 0, [&](std::uint32_t j) { multiply(j, Entry{}); });
            d.steps(kNodeStep, 0, [&](std::uint32_t i) { add_visible<D>(pixel, nodes, i, visible, sums); });
        }
    }
    template <class D, class P>
    void add_visible(P& pixel, const std::vector<std::uint32_t>& nodes, std::uint32_t i,
                     const std::array<float, kMaxSpatialSamples>& visible, Sums& sums) const {
        const auto node = lists_.read<D>(pixel, nodes, i);
        for (int m = 0; m < samples_; ++m)
            add<D>(node, m, typename D::Real(visible[static_cast<std::size_t>(m)]), sums);
    }
    // A depth comparison, and one of places for equal depths, side by side.
    template <class D>
    static typename D::Bool is_in_front(const Entry& a, const Entry& b) {
        using Real = typename D::Real;
        using Uint = typename D::Uint;
        const auto nearer = Real(a.z) < Real(b.z);
        const auto no_further = Real(a.z) <= Real(b.z);
        return either(nearer, both(no_further, Uint(b.position) < Uint(a.position)));
    }

    template <class D, class P>
    Rgb<D> over_background(const Background<D>& background, P& pixel, const Sums& sums) const {
        using Real = typename D::Real;
        std::array<Rgb<D>, kMaxSpatialSamples> color;
        for (int m = 0; m < samples_; ++m) {
            const auto k = static_cast<std::size_t>(m);
            Rgb<D> behind = samples_ == 1 ? background.mean : background.sample[k];
            if (has_tail_) {
                const Real t = pixel.load(tail_transmittance_, m);
                const Rgb<D> tail = pixel.load_rgb(tail_color_, m);
                behind = {tail.r + t * behind.r, tail.g + t * behind.g, tail.b + t * behind.b};
            }
            const Real v = sums.transmittance[k];
            color[k] = {Real(sums.color[k][0]) + v * behind.r, Real(sums.color[k][1]) + v * behind.g,
                        Real(sums.color[k][2]) + v * behind.b};
        }
        for (std::size_t stride = 1; stride < static_cast<std::size_t>(samples_); stride *= 2)
            for (std::size_t m = 0; m + stride < static_cast<std::size_t>(samples_); m += 2 * stride)
                color[m] = {color[m].r + color[m + stride].r, color[m].g + color[m + stride].g,
                            color[m].b + color[m + stride].b};
        if (samples_ == 1) return color[0];
        const Real share(1.0f / static_cast<float>(samples_));
        return {color[0].r * share, color[0].g * share, color[0].b * share};
    }

    int samples_;
    bool iterative_;
    bool has_tail_;
    Declaration declaration_;
    FragmentLists lists_;
    Field tail_color_;
    Field tail_transmittance_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(a_buffer, ABuffer)
