// What users get to see of faults.
#include "base/error.h"

#include <string>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(ErrorTest, TextQuotedFromFilesStaysOnOneLine) {
    const UserError error("file", "attribute 'a\n\x1b[31mb\x7f' is bad, \u00e4 is not");
    EXPECT_EQ(std::string(error.what()), "attribute 'a  [31mb ' is bad, \u00e4 is not");
    EXPECT_EQ(error.where(), "file");
}

TEST(ErrorTest, AnEmptyNameIsSeen) {
    EXPECT_EQ(UserError("", "cannot open").where(), "''");
}

}  // namespace
}  // namespace ropsim
