// The page of techniques is the committed one, and says what the registry says.
#include "analysis/technique_reference.h"

#include "base/atomic_file.h"
#include "rop/registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::HasSubstr;

// Of a heading's own part of the page.
std::string section(const std::string& page, const std::string& name) {
    const std::size_t start = page.find("\n## " + name + "\n");
    if (start == std::string::npos) return {};
    return page.substr(start, page.find("\n## ", start + 1) - start);
}

TEST(TechniqueReference, IsWhatIsCommitted) {
    EXPECT_EQ(read_file(ROPSIM_SOURCE_DIR "/docs/technique-reference.md"), technique_reference())
        << "renew it: ropsim list techniques --markdown > docs/technique-reference.md";
}

TEST(TechniqueReference, HasEveryTechnique) {
    const std::string page = technique_reference();
    for (const TechniqueInfo& info : technique_list()) {
        const std::string text = section(page, std::string(info.name));
        EXPECT_THAT(text, HasSubstr(std::string(info.summary)));
        for (const char* part : {"| key |", "| surface |", "| pass |", "| control path |"})
            EXPECT_THAT(text, HasSubstr(part)) << info.name;
    }
}

// Salvi et al. 2011: a node is a depth and a transmittance in float32, and every fragment reads and writes
// all of them.
TEST(TechniqueReference, AdaptiveByHand) {
    const std::string text = section(technique_reference(), "adaptive");
    for (const char* part : {"| `nodes` | 8 | an integer from 2 to 64 |", "(64 bits)", "| `nodes` | 8 |",
                             "alpha only", "raster order"})
        EXPECT_THAT(text, HasSubstr(part));
}

}  // namespace
}  // namespace ropsim
