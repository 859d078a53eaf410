// A-buffer: Carpenter 1984, as per-pixel linked lists on a GPU (Yang et al. 2010; the reference of Salvi et
// al. 2011). Every fragment is stored; resolve sorts the pixel's list by depth and composites front to back.
// Of equal depths the earlier arrival is nearer. A full pool drops fragments and counts them.
#include "rop/lists/fragment_lists.h"

#include <algorithm>
#include <bit>
#include <vector>

namespace ropsim {

class ABuffer {
 public:
    static constexpr TechniqueInfo kInfo = {
        "a_buffer", "A-buffer of per-pixel lists, sorted at resolve (Carpenter 1984)", "", true, ""};

    ABuffer(Parameters& parameters, const Screen& screen) {
        const TechniqueFormats formats(parameters);
        lists_ = FragmentLists(declaration_, formats, screen.samples);
        declaration_.passes = {{"append", Shading::kFull}};
        declaration_.paths = {"append", "overflow", "resolve"};
        declaration_.ordering = Ordering::kRaster;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        return lists_.append(d, f, pixel) ? kAppend : kOverflow;
    }

    // Two kinds of step: one a node of the list (fetch and composite), one a comparison of the sort.
    template <class D, class P>
    Rgb<D> resolve(D& d, const Background<D>& background, P& pixel, int& path) const {
        path = kResolve;
        const std::vector<std::uint32_t>& nodes = lists_.walk(d, pixel);
        std::vector<Entry>& list = scratch();
        list.clear();
        for (std::uint32_t i = 0; i < nodes.size(); ++i)
            list.push_back({lists_.depth(pixel, nodes, i), i});
        sort(d, list);
        return composite(d, background.mean, pixel, nodes, list);
    }

 private:
    enum Path { kAppend, kOverflow, kResolve };
    enum Step { kNodeStep, kSortStep };
    // A node as the resolve engine's sorter keeps it; its colour is read when it is composited.
    struct Entry {
        float z = 0;
        std::uint32_t position = 0;  // in the list: later arrivals come first
    };

    static std::vector<Entry>& scratch() {
        static thread_local std::vector<Entry> list;
        return list;
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
    Rgb<D> composite(D& d, const Rgb<D>& background, P& pixel, const std::vector<std::uint32_t>& nodes,
                     const std::vector<Entry>& list) const {
        using Real = typename D::Real;
        Rgb<D> sum{0.0f, 0.0f, 0.0f};
        Real transmittance = 1.0f;
        d.steps(kNodeStep, static_cast<std::uint32_t>(list.size()), [&](std::uint32_t i) {
            const auto node = lists_.read<D>(pixel, nodes, i < list.size() ? list[i].position : i);
            const Real v = value_of(transmittance);
            sum = {Real(value_of(sum.r)) + v * node.premultiplied.r,
                   Real(value_of(sum.g)) + v * node.premultiplied.g,
                   Real(value_of(sum.b)) + v * node.premultiplied.b};
            transmittance = v * (Real(1.0f) - node.a);
        });
        const Real v = value_of(transmittance);
        return {Real(value_of(sum.r)) + v * background.r, Real(value_of(sum.g)) + v * background.g,
                Real(value_of(sum.b)) + v * background.b};
    }

    Declaration declaration_;
    FragmentLists lists_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(a_buffer, ABuffer)
