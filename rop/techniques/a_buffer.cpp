// A-buffer: Carpenter 1984, as per-pixel linked lists on a GPU (Yang et al. 2010; the reference of Salvi et
// al. 2011). Every fragment is stored; resolve sorts the pixel's list by depth and composites front to back.
// Of equal depths the earlier arrival is nearer. A full pool drops fragments and counts them.
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <algorithm>
#include <bit>
#include <vector>

namespace ropsim {

class ABuffer {
 public:
    static constexpr TechniqueInfo kInfo = {
        "a_buffer", "A-buffer of per-pixel lists, sorted at resolve (Carpenter 1984)", "", true, ""};

    ABuffer(Parameters& parameters, const Screen&) {
        const TechniqueFormats formats(parameters);
        head_ = declaration_.surface("head", 1, Layout::kInterleaved, Initial::kClear,
                                     {FieldSpec::integer(32, kNoNode)})[0];
        const auto node = declaration_.surface(
            "nodes", 1, Layout::kPool, Initial::kClear,
            {FieldSpec::real(formats.of("color", Format::kUnorm8), 4, 0.0f),
             FieldSpec::real(Format::kFloat32, 1, 0.0f), FieldSpec::integer(32, kNoNode)});
        color_ = node[0];
        depth_ = node[1];
        next_ = node[2];
        declaration_.passes = {{"append", Shading::kFull}};
        declaration_.paths = {"append", "overflow", "resolve"};
        declaration_.ordering = Ordering::kRaster;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        using Uint = typename D::Uint;
        pixel.fetch_all(head_, 1);
        const Uint index = pixel.allocate_node();
        if (d.decide(index == Uint(kNoNode))) return kOverflow;
        pixel.write_node(color_, index);
        auto node = pixel.node(index);
        node.put_rgb(color_, 0, f.premultiplied);
        node.put(color_, 0, 3, f.a);
        node.put(depth_, 0, 0, f.z);
        node.put_bits(next_, 0, 0, pixel.load_bits(head_));
        pixel.write(head_);
        pixel.put_bits(head_, 0, 0, index);
        return kAppend;
    }

    // Two kinds of step: one a node of the list (fetch and composite), one a comparison of the sort.
    template <class D, class P>
    Rgb<D> resolve(D& d, const Background<D>& background, P& pixel, int& path) const {
        path = kResolve;
        pixel.fetch_all(head_, 1);
        std::vector<Entry>& list = scratch();
        list.clear();
        const auto head = pixel.load_bits(head_);
        gather(d, pixel, head, list);
        sort(d, list);
        return composite(d, background.mean, pixel, list);
    }

 private:
    enum Path { kAppend, kOverflow, kResolve };
    enum Step { kNodeStep, kSortStep };
    // A node as the resolve engine's sorter keeps it; its colour is read when it is composited.
    struct Entry {
        float z = 0;
        std::uint32_t node = 0;
        std::uint32_t position = 0;  // in the list: later arrivals come first
    };

    static std::vector<Entry>& scratch() {
        static thread_local std::vector<Entry> list;
        return list;
    }

    template <class D, class P, class U>
    void gather(D& d, P& pixel, const U& head, std::vector<Entry>& list) const {
        std::uint32_t index = value_of(head);
        const std::uint32_t limit = d_limit(d);
        while (index != kNoNode && list.size() < limit) {
            pixel.fetch_node(index);
            auto node = pixel.node(index);
            list.push_back({value_of(node.load(depth_)), index, static_cast<std::uint32_t>(list.size())});
            index = value_of(node.load_bits(next_));
        }
    }
    // While control paths are enumerated the head holds no list: one step of each kind is taken all the same.
    static std::uint32_t d_limit(const PlainDatapath&) { return kNoNode; }
    static std::uint32_t d_limit(const ChargedDatapath& d) { return d.enumerating() ? 0 : kNoNode; }

    // Comparisons of a binary insertion sort of n entries, whatever their values: the steps hardware is
    // charged for.
    static std::uint32_t sort_steps(std::size_t n) {
        std::uint32_t steps = 0;
        for (std::size_t i = 1; i < n; ++i) steps += static_cast<std::uint32_t>(std::bit_width(i));
        return steps;
    }
    template <class D>
    void sort(D& d, std::vector<Entry>& list) const {
        std::sort(list.begin(), list.end(), [](const Entry& a, const Entry& b) {
            return a.z < b.z || (a.z == b.z && a.position > b.position);
        });
        const std::uint32_t steps = sort_steps(list.size());
        if constexpr (D::kCharged) {
            d.steps(kSortStep, steps, [](std::uint32_t) {
                const auto nearer = Wire<float>(0.0f) < Wire<float>(1.0f);
                select(nearer, Wire<std::uint32_t>(0u), Wire<std::uint32_t>(1u));
            });
        } else {
            d.count_steps(kSortStep, steps);
        }
    }

    // Front to back: each node adds its colour under the transmittance in front of it.
    template <class D, class P>
    Rgb<D> composite(D& d, const Rgb<D>& background, P& pixel, const std::vector<Entry>& list) const {
        using Real = typename D::Real;
        Rgb<D> sum{0.0f, 0.0f, 0.0f};
        Real transmittance = 1.0f;
        d.steps(kNodeStep, static_cast<std::uint32_t>(list.size()), [&](std::uint32_t i) {
            auto node = pixel.node(i < list.size() ? list[i].node : 0);
            const Rgb<D> color = node.load_rgb(color_);
            const Real alpha = node.load(color_, 0, 3);
            const Real v = value_of(transmittance);
            sum = {Real(value_of(sum.r)) + v * color.r, Real(value_of(sum.g)) + v * color.g,
                   Real(value_of(sum.b)) + v * color.b};
            transmittance = v * (Real(1.0f) - alpha);
        });
        const Real v = value_of(transmittance);
        return {Real(value_of(sum.r)) + v * background.r, Real(value_of(sum.g)) + v * background.g,
                Real(value_of(sum.b)) + v * background.b};
    }

    Declaration declaration_;
    Field head_;
    Field color_;
    Field depth_;
    Field next_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(a_buffer, ABuffer)
