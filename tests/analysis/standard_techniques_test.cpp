// What studies over all techniques run: made from the registry, and complete.
#include "analysis/standard_techniques.h"

#include "rop/registry.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

Screen with_camera() {
    Screen screen;
    screen.camera = Camera{};
    screen.camera->near_plane = 0.1f;
    screen.camera->far_plane = 100;
    screen.camera->fovy_degrees = 45;
    return screen;
}

std::string name_of(const std::string& technique) {
    return technique.substr(0, technique.find(':'));
}

std::map<std::string, std::string> resolved(const std::string& technique) {
    TechniqueSpec spec = parse_technique(technique, "test");
    make_operation(spec, with_camera());
    std::map<std::string, std::string> values{{"", spec.name}};
    for (const auto& [key, entry] : spec.parameters.resolved()) values[key] = entry.value;
    return values;
}

TEST(StandardTechniques, EveryTechniqueWithAColourImageTakesPart) {
    const std::vector<std::string> defaults = techniques_at_defaults();
    const std::vector<std::string> all = standard_techniques();
    for (const TechniqueInfo& info : technique_list()) {
        const std::string name(info.name);
        TechniqueSpec spec = parse_technique(name, "test");
        const bool color = make_operation(spec, with_camera())->declaration().image_is_color;
        const auto mine = [&](const std::string& technique) { return name_of(technique) == name; };
        EXPECT_EQ(std::count_if(defaults.begin(), defaults.end(), mine), color ? 1 : 0) << name;
        EXPECT_EQ(std::any_of(all.begin(), all.end(), mine), color) << name;
    }
}

TEST(StandardTechniques, NoConfigurationComesTwice) {
    std::set<std::map<std::string, std::string>> seen;
    for (const std::string& technique : standard_techniques())
        EXPECT_TRUE(seen.insert(resolved(technique)).second) << technique;
}

TEST(StandardTechniques, EveryConfigurationIsTaken) {
    const std::vector<std::string> all = standard_techniques();
    for (const std::string& text : standard_configurations()) EXPECT_THAT(all, testing::Contains(text));
}

TEST(StandardTechniques, KnownTechniquesHaveAFamily) {
    const std::size_t other = technique_families().size() - 1;
    for (const TechniqueInfo& info : technique_list())
        if (!info.name.ends_with("shadow_map")) {
            EXPECT_LT(family_of(std::string(info.name)), other) << info.name;
        }
    EXPECT_EQ(family_of("never_heard_of:key=1"), other);
    EXPECT_EQ(family_of("slab:layers=4"), family_of("slab"));
}

}  // namespace
}  // namespace ropsim
