// Miss status holding registers: one entry a line with misses outstanding, merging sectors and waiting slots.
#pragma once

#include "base/error.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// `Slots` is a word with a bit for each slot that can wait (quads or reads in flight). Entries are few
// (4..64), so a linear search beats a hash.
template <class Slots>
class BasicMshrTable {
 public:
    struct Entry {
        std::uint64_t line_address = 0;
        std::uint32_t outstanding = 0;  // sectors asked for and not yet here
        Slots waiting = 0;              // slots to wake when `outstanding` is empty
        std::int32_t cache_line = -1;   // the RopCache line that was allocated
        bool used = false;
    };

    explicit BasicMshrTable(int entries) : entries_(static_cast<std::size_t>(entries)) {
        for (int i = entries; i > 0; --i) free_.push_back(i - 1);
    }

    // The entry of this line, or -1.
    int find(std::uint64_t line_address) const {
        if (empty()) return -1;
        for (std::size_t i = 0; i < entries_.size(); ++i)
            if (entries_[i].used && entries_[i].line_address == line_address) return static_cast<int>(i);
        return -1;
    }
    // A new entry for a line that has none, or -1 when all are in use.
    int allocate(std::uint64_t line_address, int cache_line) {
        if (full()) return -1;
        const int entry = free_.back();
        free_.pop_back();
        (*this)[entry] = {line_address, 0, 0, cache_line, true};
        return entry;
    }
    // Adds sectors that were just requested, and the slot that waits for them (and for those already on their
    // way).
    void add(int entry, std::uint32_t sectors, int slot) {
        Entry& e = (*this)[entry];
        e.outstanding |= sectors;
        e.waiting |= Slots{1} << slot;
    }
    // Sectors arrived. Returns the slots to wake and frees the entry once nothing is outstanding; 0 until
    // then.
    Slots arrive(int entry, std::uint32_t sectors) {
        Entry& e = (*this)[entry];
        CHECK((sectors & ~e.outstanding) == 0, "sectors {:x} of {:x}", sectors, e.outstanding);
        e.outstanding &= ~sectors;
        if (e.outstanding != 0) return 0;
        e.used = false;
        free_.push_back(entry);
        return e.waiting;
    }

    Entry& operator[](int entry) { return entries_[static_cast<std::size_t>(entry)]; }
    const Entry& operator[](int entry) const { return entries_[static_cast<std::size_t>(entry)]; }
    bool full() const { return free_.empty(); }
    bool empty() const { return used() == 0; }
    int used() const { return static_cast<int>(entries_.size() - free_.size()); }

 private:
    std::vector<Entry> entries_;
    std::vector<int> free_;
};
using MshrTable = BasicMshrTable<std::uint32_t>;

}  // namespace ropsim
