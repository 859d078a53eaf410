// Merging of sectors and waiting slots.
#include "memory/mshr_table.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(MshrTable, MergesAndWakesWhenAllSectorsAreHere) {
    MshrTable table(2);
    EXPECT_EQ(table.find(0x100), -1);
    const int a = table.allocate(0x100, 7);
    const int b = table.allocate(0x200, 8);
    EXPECT_TRUE(table.full());
    EXPECT_EQ(table.allocate(0x300, 9), -1);
    EXPECT_EQ(table.find(0x100), a);
    EXPECT_EQ(table[a].cache_line, 7);
    table.add(a, 0b0011, 4);
    table.add(a, 0b0100, 31);
    table.add(a, 0, 0);  // waits for what is on its way
    table.add(b, 1, 5);
    EXPECT_EQ(table.arrive(a, 0b0010), 0u);
    EXPECT_EQ(table.arrive(a, 0b0101), 1u << 4 | 1u << 31 | 1u);
    EXPECT_EQ(table.find(0x100), -1);
    EXPECT_EQ(table.used(), 1);
    EXPECT_EQ(table.arrive(b, 1), 1u << 5);
    EXPECT_TRUE(table.empty());
}

TEST(MshrTableDeathTest, RefusesSectorsThatNobodyAskedFor) {
    MshrTable table(1);
    const int a = table.allocate(0, 0);
    table.add(a, 1, 0);
    EXPECT_DEATH(table.arrive(a, 2), "sectors");
}

}  // namespace
}  // namespace ropsim
