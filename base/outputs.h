// Files that a command writes: where they go, and what they must not replace.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

namespace ropsim {

// Makes the directory, with those above it, and removes what an earlier study left under these names: it
// must not stand beside the new files if these are cut short. Throws UserError.
void start_directory(const std::string& directory, std::initializer_list<const char*> files = {});

// Throws UserError, which names the output, if one is the same file as an input, under whatever name. Inputs
// that do not exist are left to those who read them.
void keep_inputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

// The paths of files in a directory.
std::vector<std::string> files_in(const std::string& directory, std::initializer_list<const char*> files);

}  // namespace ropsim
