// The floor plan of docs/architecture.md, held against every #include of the tree.
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;

// Folders a folder may include, itself apart.
const std::map<std::string, std::set<std::string>> may_include = {
    {"base", {}},
    {"traces", {"base"}},
    {"rop", {"base", "traces"}},
    {"memory", {"base"}},
    {"model", {"base", "traces", "rop", "memory"}},
    {"capture", {"base", "traces"}},
    {"analysis", {"base", "traces", "rop", "memory", "model", "capture"}},
    {"cli", {"base", "traces", "rop", "memory", "model", "capture", "analysis"}},
};
// Libraries a folder must not see, as the start of the header's name.
const std::map<std::string, std::vector<std::string>> must_not_see = {
    {"base", {"systemc", "tlm", "glm", "OpenEXR", "Imf", "epoxy"}},
    {"traces", {"systemc", "tlm", "epoxy"}},
    {"rop", {"systemc", "tlm", "epoxy"}},
    {"memory", {"glm", "OpenEXR", "Imf", "epoxy"}},
    {"model", {"epoxy"}},
    {"capture", {"systemc", "tlm"}},
};

std::vector<fs::path> sources(const std::string& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(ROPSIM_SOURCE_DIR) / folder))
        if (entry.path().extension() == ".cpp" || entry.path().extension() == ".h")
            files.push_back(entry.path());
    return files;
}

std::vector<std::string> includes(const fs::path& file) {
    static const std::regex pattern(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
    std::vector<std::string> names;
    std::ifstream in(file);
    std::smatch match;
    for (std::string line; std::getline(in, line);)
        if (std::regex_search(line, match, pattern)) names.push_back(match[1]);
    return names;
}

TEST(Tree, FoldersIncludeOnlyWhatTheFloorPlanAllows) {
    std::size_t seen = 0;
    for (const auto& [folder, allowed] : may_include) {
        for (const fs::path& file : sources(folder)) {
            for (const std::string& name : includes(file)) {
                ++seen;
                const std::string top = name.substr(0, name.find('/'));
                EXPECT_NE(top, "tests") << file << " sees the tests: " << name;
                if (name.find('/') == std::string::npos || !may_include.contains(top) || top == folder)
                    continue;
                EXPECT_TRUE(allowed.contains(top)) << file << " must not include " << name;
            }
        }
    }
    EXPECT_GT(seen, 300u) << "the sources were not found";
}

TEST(Tree, FoldersDoNotSeeLibrariesBeyondTheirs) {
    for (const auto& [folder, banned] : must_not_see)
        for (const fs::path& file : sources(folder))
            for (const std::string& name : includes(file))
                for (const std::string& start : banned)
                    EXPECT_FALSE(name.starts_with(start)) << file << " includes " << name;
}

TEST(Tree, NoFileIsADrawerForLeftovers) {
    for (const auto& [folder, allowed] : may_include)
        for (const fs::path& file : sources(folder))
            for (const char* name : {"util", "utils", "common", "misc", "helpers"})
                EXPECT_NE(file.stem(), name) << file;
}

TEST(Tree, EveryFileSaysFirstWhatItIs) {
    for (const auto& [folder, allowed] : may_include) {
        for (const fs::path& file : sources(folder)) {
            // A source beside its header may leave that to the header.
            if (file.extension() == ".cpp" && fs::exists(fs::path(file).replace_extension(".h"))) continue;
            std::ifstream in(file);
            std::string line;
            std::getline(in, line);
            EXPECT_TRUE(line.starts_with("// ")) << file << " begins with: " << line;
        }
    }
}

// Two types of one name are one to the linker, which takes the members of either for both.
TEST(Tree, NoTypeIsDefinedTwice) {
    const std::regex space(R"(^namespace ([\w:]+) \{)");
    const std::regex type(R"(^(?:struct|class|enum class|enum) (?:alignas\(\d+\) )?(\w+)\b(?!::|<)[^;]*\{)");
    std::map<std::string, fs::path> defined;
    for (const auto& [folder, allowed] : may_include) {
        for (const fs::path& file : sources(folder)) {
            if (file.extension() != ".h") continue;
            std::ifstream in(file);
            std::string within;
            std::smatch match;
            for (std::string line; std::getline(in, line);) {
                if (std::regex_search(line, match, space)) within = match[1].str() + "::";
                if (!std::regex_search(line, match, type)) continue;
                const auto [first, is_new] = defined.emplace(within + match[1].str(), file);
                EXPECT_TRUE(is_new) << first->first << ": " << first->second << " and " << file;
            }
        }
    }
    EXPECT_GT(defined.size(), 300u) << "the types were not found";
}

// The C library takes other paths through these on processors with fused multiply-add, and their last bit
// changes from version to version: what results depend on has rop/transcendental.h and traces/exact_log2.h.
TEST(Tree, ResultsDoNotHangOnTheCLibrarysTranscendentals) {
    const std::regex call(
        R"((std|glm)::(pow|exp2?|exp[fl]|expm1|log(2|10|1p|b)?|sin|cos|tan|a?(sin|cos|tan)h?|)"
        R"(atan2|cbrt|hypot|erfc?|[lt]gamma)\()");
    ASSERT_TRUE(std::regex_search("20 * std::log10(x)", call) && std::regex_search("glm::pow(a, b)", call));
    for (const char* folder : {"base", "traces", "rop", "memory", "model"}) {
        for (const fs::path& file : sources(folder)) {
            std::ifstream in(file);
            int number = 0;
            for (std::string line; std::getline(in, line);) {
                ++number;
                EXPECT_FALSE(std::regex_search(line, call)) << file << ":" << number << ": " << line;
            }
        }
    }
}

}  // namespace
