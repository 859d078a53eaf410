// Fuzzes files of hardware and of DRAM devices: what is accepted comes back the same from the values in
// force.
#include "base/parameters.h"
#include "memory/dram_device.h"
#include "model/machine_config.h"
#include "tests/fuzz/fuzz_input.h"

#include <fstream>

// libsystemc calls it from the main() that it brings along and nobody uses.
extern "C" int sc_main(int, char**) {
    return 0;
}

namespace {

using namespace ropsim;

// As run.json gives them, a line each.
std::string values_in_force(const Parameters& parameters) {
    std::string text;
    for (const auto& [key, resolved] : parameters.resolved())
        text += fmt::format("{} = {}\n", key, resolved.value);
    return text;
}

void read_hardware(const std::string& text, std::string& in_force) {
    Parameters parameters = Parameters::from_toml_text("hardware", text, "input");
    machine_config(parameters, "input");
    parameters.close();
    in_force = values_in_force(parameters);
}

void read_device(const std::string& text) {
    const std::string path = fuzz::scratch_path("device.toml");
    std::ofstream(path, std::ios::binary) << text;
    Parameters parameters("memory");
    parameters.set("dram.device", path, "--device");
    const DramConfig config = dram_config(parameters);
    parameters.close();
    CHECK(config.capacity_bytes() > 0 && config.peak_bytes_per_second() > 0);
    CHECK(config.burst_bytes() > 0 && config.columns() > 0);
}

}  // namespace

// The first byte chooses what the file is.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
    if (data[0] % 2 != 0) {
        fuzz::accepted([&] { read_device(text); });
        return 0;
    }
    std::string in_force;
    if (!fuzz::accepted([&] { read_hardware(text, in_force); })) return 0;
    std::string again;
    CHECK(fuzz::accepted([&] { read_hardware(in_force, again); }), "{}", in_force);
    CHECK(again == in_force, "{}\nbut\n{}", in_force, again);
    return 0;
}
