// Parameters: typed reads, ranges, places in messages, unknown keys.
#include "base/parameters.h"

#include "base/error.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

// The line the program would print for a UserError that `action` throws; "(nothing thrown)" without one.
template <typename Action>
std::string message_of(Action&& action) {
    try {
        action();
    } catch (const UserError& error) {
        return error.where() + ": " + error.what();
    }
    return "(nothing thrown)";
}

Parameters list(const std::string& text) {
    return Parameters::from_list("technique 'adaptive'", text, "--technique");
}

TEST(Parameters, ReadsEveryTypeAndFallsBack) {
    Parameters p = list("nodes=16,scale=2.5,fast=true,name=abc,mode=b,limit=inf");
    EXPECT_EQ(p.get_integer("nodes", 8, 2, 64), 16);
    EXPECT_EQ(p.get_real("scale", 1, 0, 10), 2.5);
    EXPECT_TRUE(p.get_flag("fast", false));
    EXPECT_EQ(p.get_string("name", ""), "abc");
    EXPECT_EQ(p.get_choice("mode", "a", {"a", "b"}), "b");
    EXPECT_EQ(p.get_real("limit", 0, 0, std::numeric_limits<double>::infinity()),
              std::numeric_limits<double>::infinity());
    EXPECT_EQ(p.get_integer("absent", 7, 0, 9), 7);
    EXPECT_NO_THROW(p.close());
}

TEST(Parameters, MessagesTellWhatWhereAndHowToMend) {
    EXPECT_EQ(message_of([] { list("nodes=1").get_integer("nodes", 8, 2, 64); }),
              "technique 'adaptive': nodes=1: must be an integer from 2 to 64");
    EXPECT_EQ(message_of([] { list("nodes=1.5").get_integer("nodes", 8, 1, 64); }),
              "technique 'adaptive': nodes=1.5: must be an integer from 1 to 64");
    EXPECT_EQ(message_of([] { list("scale=nan").get_real("scale", 1, 0, 2); }),
              "technique 'adaptive': scale=nan: must be a number from 0 to 2");
    EXPECT_EQ(message_of([] { list("fast=maybe").get_flag("fast", false); }),
              "technique 'adaptive': fast=maybe: must be true or false");
    EXPECT_EQ(message_of([] {
                  list("mode=c").get_choice("mode", "a", {"a", "b"});
              }),
              "technique 'adaptive': mode=c: must be one of a, b");
}

TEST(Parameters, RefusesIntegersBeyondTheirBoundsAndType) {
    for (const char* text : {"n=2", "n=11", "n=", "n=5x", "n= 5 5", "n=99999999999999999999", "n=0x5"})
        EXPECT_THROW(list(text).get_integer("n", 5, 3, 10), UserError) << text;
    for (const char* text : {"n=3", "n=10", "n= 5 ", "n=+5"})
        EXPECT_NO_THROW(list(text).get_integer("n", 5, 3, 10)) << text;
}

TEST(Parameters, CloseNamesPlaceAndNearestKey) {
    Parameters p = list("nods=8");
    p.get_integer("nodes", 8, 2, 64);
    p.get_string("format", "paper");
    EXPECT_EQ(message_of([&] { p.close(); }), "technique 'adaptive': nods: no such key; did you mean nodes?");

    Parameters far = list("zzzzzzzz=8");
    far.get_integer("nodes", 8, 2, 64);
    far.get_string("format", "paper");
    EXPECT_THAT(message_of([&] { far.close(); }), HasSubstr("the keys are format, nodes"));
    EXPECT_THAT(message_of([] { list("a=1").close(); }), HasSubstr("it takes no keys"));
}

TEST(Parameters, RefusesMalformedAndRepeatedListItems) {
    EXPECT_THAT(message_of([] { list("nodes"); }), HasSubstr("--technique: 'nodes' is not key=value"));
    EXPECT_THAT(message_of([] { list("=3"); }), HasSubstr("is not key=value"));
    EXPECT_THAT(message_of([] { list("n=3,n=4"); }), HasSubstr("n is given twice"));
    EXPECT_NO_THROW(list(""));
}

TEST(Parameters, TomlTablesBecomeDottedKeysWithTheirLines) {
    Parameters p = Parameters::from_toml_text(
        "hardware preset 'desktop'", "name = \"x\"\n[dram]\nbanks = 3\nrate = 1.5\n[dram.timing]\nrcd = 14\n",
        "desktop.toml");
    EXPECT_EQ(p.get_string("name", ""), "x");
    EXPECT_EQ(p.get_real("dram.rate", 0, 0, 9), 1.5);
    EXPECT_EQ(p.get_integer("dram.timing.rcd", 0, 0, 99), 14);
    EXPECT_EQ(message_of([&] { p.get_integer("dram.banks", 4, 4, 64); }),
              "desktop.toml:3: dram.banks=3: must be an integer from 4 to 64");
}

TEST(Parameters, UnreadTomlKeyIsNamedWithFileAndLine) {
    Parameters p =
        Parameters::from_toml_text("hardware preset 'desktop'", "[rop]\nlane = 3\n", "desktop.toml");
    p.get_integer("rop.lanes", 4, 1, 64);
    EXPECT_EQ(message_of([&] { p.close(); }),
              "desktop.toml:2: rop.lane: hardware preset 'desktop' has no such key; did you mean rop.lanes?");
}

TEST(Parameters, BrokenTomlNamesFileAndLine) {
    EXPECT_THAT(message_of([] { Parameters::from_toml_text("c", "a = 1\nb = = 2\n", "f.toml"); }),
                HasSubstr("f.toml:2: not valid TOML"));
    EXPECT_THAT(message_of([] { Parameters::from_toml_text("c", "a = 1\nb = [1, 2]\n", "f.toml"); }),
                HasSubstr("f.toml:2: b: must be one number"));
    EXPECT_THAT(message_of([] { Parameters::from_toml_file("c", "/nonexistent/f.toml"); }),
                HasSubstr("/nonexistent/f.toml"));
}

TEST(Parameters, SetAndMergeReplaceAndCarryTheirPlaces) {
    Parameters p = Parameters::from_toml_text("preset", "lanes = 3\nclock = 1\n", "f.toml");
    p.set("lanes", "500", "--set");
    EXPECT_EQ(message_of([&] { p.get_integer("lanes", 4, 1, 64); }),
              "--set: lanes=500: must be an integer from 1 to 64");
    Parameters more("preset");
    more.set("lanes", "5", "--set");
    p.merge(more);
    EXPECT_EQ(p.get_integer("lanes", 4, 1, 64), 5);
    EXPECT_EQ(p.get_integer("clock", 4, 1, 64), 1);
    EXPECT_EQ(p.where("clock"), "f.toml:2: clock=1");
}

TEST(Parameters, ResolvedHoldsEveryReadKeyInTomlSyntax) {
    Parameters p = list("nodes=+16,name=a\"b");
    p.get_integer("nodes", 8, 2, 64);
    p.get_real("scale", 2, 0, 10);
    p.get_flag("fast", false);
    p.get_string("name", "");
    const auto& resolved = p.resolved();
    ASSERT_EQ(resolved.size(), 4u);
    EXPECT_EQ(resolved.at("nodes").value, "16");
    EXPECT_TRUE(resolved.at("nodes").given);
    EXPECT_EQ(resolved.at("scale").value, "2.0");
    EXPECT_FALSE(resolved.at("scale").given);
    EXPECT_EQ(resolved.at("fast").value, "false");
    EXPECT_EQ(resolved.at("name").value, "\"a\\\"b\"");
}

}  // namespace
}  // namespace ropsim
