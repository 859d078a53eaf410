// `ropsim stress`: what it refuses before it runs anything.
#include "tests/cli/cli_driver.h"

#include <filesystem>

namespace ropsim {
namespace {

class StressCli : public Cli {};

// Tables that have no place on the page are no matter of minutes.
TEST_F(StressCli, APageWithoutMarksIsRefusedBeforeTheRun) {
    write_file(path("page.md"), "# A page\n");
    for (const std::vector<std::string>& more :
         {std::vector<std::string>{}, std::vector<std::string>{"--worst"}}) {
        std::vector<std::string> command{"stress", "-o", path("out"), "--page", path("page.md")};
        command.insert(command.end(), more.begin(), more.end());
        expect_refused(command, {"page.md", "<!-- stress "});
        EXPECT_FALSE(std::filesystem::exists(path("out")));
    }
    // Half a mark, too; and marks of the other study's tables.
    write_file(path("page.md"), "<!-- stress faults -->\n");
    expect_refused({"stress", "-o", path("out"), "--page", path("page.md")}, {"<!-- end faults -->"});
    write_file(path("page.md"), "<!-- stress faults -->\n<!-- end faults -->\n");
    expect_refused({"stress", "--worst", "-o", path("out"), "--page", path("page.md")},
                   {"<!-- stress worst -->"});
    EXPECT_FALSE(std::filesystem::exists(path("out")));
    expect_refused({"stress", "-o", path("out"), "--page", path("none.md")}, {"none.md"});
}

}  // namespace
}  // namespace ropsim
