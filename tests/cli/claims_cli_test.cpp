// `ropsim claims` as a user meets it.
#include "tests/cli/cli_driver.h"

#include <set>

namespace ropsim {
namespace {

using nlohmann::json;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class ClaimsCli : public Cli {};

// Everything, at the size that ./check affords.
TEST_F(ClaimsCli, QuickHasAnHonestRowForEveryClaim) {
    const json rows = expect_json({"claims", "--quick", "--json"});
    std::set<std::string> ids;
    for (const json& row : rows) {
        const std::string id = row["id"];
        EXPECT_TRUE(ids.insert(id).second) << id;
        for (const char* key : {"paper", "place", "claim", "verdict", "why"}) {
            ASSERT_TRUE(row[key].is_string()) << id << " " << key;
            EXPECT_FALSE(row[key].get<std::string>().empty()) << id << " " << key;
        }
        EXPECT_THAT(row["verdict"].get<std::string>(),
                    AnyOf("reproduced", StartsWith("reproduced under "),
                          "does not follow from its own definition", "not reproducible without its assets"))
            << id;
        EXPECT_FALSE(row["printed"].is_null()) << id;
        // Nothing here is of the kind of some of the papers' scenes.
        if (row["verdict"] != "not reproducible without its assets") {
            EXPECT_FALSE(row["worst_case"].is_null() && row["measured"].is_null()) << id;
        }
        // What was not measured would be null inside a list too.
        for (const char* key : {"worst_case", "measured"}) {
            if (!row[key].is_array()) continue;
            for (const json& value : row[key]) EXPECT_TRUE(value.is_number()) << id << " " << key;
        }
        EXPECT_EQ(row["quick"], true);
    }
    const json listed = expect_json({"list", "claims", "--json"});
    EXPECT_EQ(listed.size(), ids.size());
    for (const json& entry : listed) EXPECT_TRUE(ids.contains(entry["name"].get<std::string>()));
}

TEST_F(ClaimsCli, OneAloneWritesItsFiles) {
    const std::string table = expect_done({"claims", "lk-fig5d", "st-passes", "--quick", "-o", path("out")});
    EXPECT_THAT(table, HasSubstr("lk-fig5d"));
    EXPECT_THAT(table, HasSubstr("st-passes"));
    EXPECT_THAT(table, HasSubstr("2 claims: 2 reproduced"));
    const json rows = json::parse(read_file(path("out/claims.json")));
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0]["id"], "st-passes");  // in the order of the list
    EXPECT_EQ(rows[0]["printed"], json({3.0, 5.0}));
    EXPECT_EQ(rows[0]["worst_case"], json({3.0, 5.0}));
    EXPECT_EQ(rows[1]["verdict"], "reproduced");
    EXPECT_THAT(read_file(path("out/claims.md")), HasSubstr("| `lk-fig5d` |"));
    EXPECT_TRUE(exists("out/runs"));
    // Again, from the same traces: the same bytes.
    const std::string text = read_file(path("out/claims.json"));
    EXPECT_EQ(expect_done({"claims", "lk-fig5d", "st-passes", "--quick", "--json", "-o", path("out")}), text);
    EXPECT_EQ(expect_done({"claims", "lk-fig5d", "st-passes", "--quick", "--markdown"}),
              read_file(path("out/claims.md")));
}

TEST_F(ClaimsCli, RefusesAnUnknownId) {
    expect_refused({"claims", "st-pases", "--quick", "-o", path("out")},
                   {"ID", "st-pases", "near it are st-passes"});
    EXPECT_FALSE(exists("out"));
    expect_misused({"claims", "--json", "--markdown"});
}

}  // namespace
}  // namespace ropsim
