// Lists of slots against vectors.
#include "memory/slot_lists.h"

#include "base/random.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr std::size_t kSlots = 12;
constexpr std::size_t kLists = 3;

std::vector<std::uint16_t> slots_of(const SlotLists& lists, std::size_t list) {
    std::vector<std::uint16_t> slots;
    for (std::uint16_t slot = lists.first(list); slot != lists.end(list) && slots.size() <= kSlots;
         slot = lists.after(slot))
        slots.push_back(slot);
    return slots;
}

TEST(SlotLists, AreEmptyAtFirst) {
    const SlotLists lists(kSlots, kLists);
    EXPECT_EQ(lists.lists(), kLists);
    for (std::size_t list = 0; list < kLists; ++list) {
        EXPECT_TRUE(lists.empty(list));
        EXPECT_TRUE(lists.is_end(lists.first(list)));
    }
}

// Slots come to the end of any list and leave from anywhere.
TEST(SlotLists, KeepTheOrderOfArrival) {
    SlotLists lists(kSlots, kLists);
    std::array<std::vector<std::uint16_t>, kLists> expected;
    std::array<std::size_t, kSlots> list_of{};
    list_of.fill(kLists);
    for (std::uint64_t round = 0; round < 4000; ++round) {
        const std::uint64_t r = mix64(round);
        const auto slot = static_cast<std::uint16_t>(r % kSlots);
        std::size_t& list = list_of[slot];
        if (list == kLists) {
            list = (r >> 16) % kLists;
            lists.append(list, slot);
            expected[list].push_back(slot);
        } else {
            lists.remove(slot);
            std::erase(expected[list], slot);
            list = kLists;
        }
        for (std::size_t l = 0; l < kLists; ++l) {
            ASSERT_EQ(slots_of(lists, l), expected[l]) << round;
            ASSERT_EQ(lists.empty(l), expected[l].empty());
            for (const std::uint16_t s : expected[l]) {
                ASSERT_FALSE(lists.is_end(s));
                ASSERT_EQ(lists.is_first(s), s == expected[l].front());
            }
        }
    }
}

}  // namespace
}  // namespace ropsim
