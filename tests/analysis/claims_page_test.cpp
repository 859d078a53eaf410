// docs/claims.md says of every claim that needs no simulation what comes out now, to the last digit shown.
#include "analysis/claims/claims.h"
#include "analysis/claims/output.h"
#include "base/atomic_file.h"

#include <cstddef>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

std::set<std::string> rows_of(const std::string& page) {
    std::set<std::string> rows;
    std::istringstream lines(page);
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with("| `")) rows.insert(line);
    return rows;
}

TEST(ClaimsPage, HasTheRowsOfToday) {
    const std::set<std::string> page = rows_of(read_file(ROPSIM_SOURCE_DIR "/docs/claims.md"));
    EXPECT_EQ(page.size(), all_claims().size()) << "a claim without a row, or a row without a claim";
    ClaimsOptions options;
    for (const Claim& claim : all_claims())
        if (!claim.simulates) options.ids.push_back(claim.id);
    ASSERT_GE(options.ids.size(), 100u);
    const std::set<std::string> today = rows_of(claims_markdown(run_claims(options), false));
    EXPECT_EQ(today.size(), options.ids.size());
    for (const std::string& row : today)
        EXPECT_TRUE(page.contains(row)) << row << "\nrenew the page: ropsim claims -o out, out/claims.md";
}

}  // namespace
}  // namespace ropsim
