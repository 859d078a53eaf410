// The test vectors of docs/random-number-vectors.txt: "name arguments = result", hexadecimal.
#pragma once

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace ropsim::test {

struct TestVector {
    std::string line;
    std::string name;
    std::vector<std::uint64_t> arguments;
    std::uint64_t result = 0;

    std::uint32_t word(std::size_t i) const { return static_cast<std::uint32_t>(arguments.at(i)); }
};

inline std::vector<TestVector> read_test_vectors(const std::string& path) {
    std::vector<TestVector> vectors;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        TestVector vector;
        vector.line = line;
        std::istringstream words(line);
        words >> vector.name;
        for (std::string word; words >> word && word != "=";)
            vector.arguments.push_back(std::stoull(word, nullptr, 16));
        words >> std::hex >> vector.result;
        vectors.push_back(vector);
    }
    return vectors;
}

}  // namespace ropsim::test
