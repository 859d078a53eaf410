// Distances of names counted by hand.
#include "base/edit_distance.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(EditDistance, CountsChanges) {
    EXPECT_EQ(edit_distance("", ""), 0u);
    EXPECT_EQ(edit_distance("", "abc"), 3u);
    EXPECT_EQ(edit_distance("samples", "sample"), 1u);
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
    EXPECT_EQ(edit_distance("ab", "ba"), 2u);
}

}  // namespace
}  // namespace ropsim
