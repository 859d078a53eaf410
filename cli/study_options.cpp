// What commands that run several techniques have in common.
#include "cli/study_options.h"

#include "model/machine_config.h"

#include <fmt/format.h>

namespace ropsim {

void add_technique_option(CLI::App& command, std::vector<std::string>& techniques,
                          const std::string& description) {
    command.add_option("--technique", techniques, description)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void check_hardware(const std::string& hardware, const std::vector<std::string>& settings) {
    Parameters parameters = hardware_parameters(hardware);
    for (const std::string& setting : settings) set_from_text(parameters, setting, "--set");
    machine_config(parameters, hardware);
    parameters.close();
}

}  // namespace ropsim
