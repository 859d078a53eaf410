// Lists of numbered slots, each slot in one list at most.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

// Each list is a ring through an end of its own, so that nothing is asked when a slot comes or goes: in a
// simulation, whether it is a list's only one is as good as random.
class SlotLists {
 public:
    // Together fewer than 65,536. Slots are numbered from 0, lists, too.
    SlotLists(std::size_t slots, std::size_t lists) : ends_(static_cast<std::uint16_t>(slots)) {
        for (std::size_t i = 0; i < slots + lists; ++i)
            links_.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(i)});
    }
    std::size_t lists() const { return links_.size() - ends_; }
    // What comes after the last and before the first of a list: no slot.
    std::uint16_t end(std::size_t list) const { return static_cast<std::uint16_t>(ends_ + list); }
    bool is_end(std::uint16_t slot) const { return slot >= ends_; }
    bool empty(std::size_t list) const { return first(list) == end(list); }
    std::uint16_t first(std::size_t list) const { return links_[ends_ + list].after; }
    std::uint16_t after(std::uint16_t slot) const { return links_[slot].after; }
    bool is_first(std::uint16_t slot) const { return is_end(links_[slot].before); }
    // A slot that is in no list.
    void append(std::size_t list, std::uint16_t slot) {
        Link& ends = links_[ends_ + list];
        links_[slot] = {ends.before, end(list)};
        links_[ends.before].after = slot;
        ends.before = slot;
    }
    // From the list that it is in.
    void remove(std::uint16_t slot) {
        const Link link = links_[slot];
        links_[link.before].after = link.after;
        links_[link.after].before = link.before;
    }

 private:
    struct Link {
        std::uint16_t before, after;
    };
    std::vector<Link> links_;  // of the slots, then the ends of the lists
    std::uint16_t ends_;       // the first of these
};

}  // namespace ropsim
