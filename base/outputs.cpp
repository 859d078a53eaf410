#include "base/outputs.h"

#include "base/error.h"

#include <filesystem>

namespace ropsim {

namespace fs = std::filesystem;

void start_directory(const std::string& directory, std::initializer_list<const char*> files) {
    std::error_code failure;
    fs::create_directories(directory, failure);
    if (failure)
        throw UserError(directory, fmt::format("cannot be made: {}; choose another -o", failure.message()));
    for (const char* name : files) fs::remove(fs::path(directory) / name, failure);
}

void keep_inputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
    std::error_code absent;
    for (const std::string& output : outputs)
        for (const std::string& input : inputs)
            if (fs::equivalent(input, output, absent))
                throw UserError(output,
                                fmt::format("is also an input{} and would be lost; choose another output",
                                            input == output ? "" : ", " + input));
}

std::vector<std::string> files_in(const std::string& directory, std::initializer_list<const char*> files) {
    std::vector<std::string> paths;
    for (const char* name : files) paths.push_back((fs::path(directory) / name).string());
    return paths;
}

}  // namespace ropsim
