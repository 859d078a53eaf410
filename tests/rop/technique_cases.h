// The techniques the conformance tests run over: every one of technique_list(), so that a new one needs no
// line here.
#pragma once

#include "tests/rop/random_fragments.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim::test {

// Every technique with its defaults, in both formats, and corners of parameters worth the walk.
inline std::vector<std::string> technique_texts() {
    std::vector<std::string> texts;
    for (const TechniqueInfo& t : technique_list())
        for (const char* format : {"paper", "float32"})
            texts.push_back(std::string(t.name) + ":format=" + format);
    for (const char* corner :
         {"adaptive:nodes=2", "adaptive:nodes=5,depth_format=unorm24,transmittance_format=unorm8",
          "adaptive:nodes=64", "slab:layers=3,bits=inf", "slab:layers=1,bits=1", "slab:layers=64,bits=inf",
          "slab:layers=5,bits=256", "slab:layers=4,depth_format=float16",
          "stochastic:samples=12,depth_format=unorm24", "stochastic:samples=32,color_format=rgb9e5",
          "laine_karras:samples=12,color_format=r11g11b10", "laine_karras:samples=64",
          "alpha_blend:color_format=rgb9e5", "weighted_blended:color_format=float32"})
        texts.push_back(corner);
    return texts;
}

inline std::vector<std::string> technique_names() {
    std::vector<std::string> names;
    for (const TechniqueInfo& t : technique_list()) names.emplace_back(t.name);
    return names;
}

// A case as the name of a test.
inline std::string test_name(const testing::TestParamInfo<std::string>& info) {
    std::string name = info.param;
    std::ranges::replace_if(
        name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
    return name;
}

}  // namespace ropsim::test
