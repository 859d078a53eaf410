// Fuzzes whole configurations: technique, fidelity and any keys of the hardware. One that can be simulates a
// small trace, with the image that the default machine makes; one that cannot be is refused with the name of
// a key.
#include "model/machine_config.h"
#include "model/run.h"
#include "rop/registry.h"
#include "tests/fuzz/fuzz_input.h"
#include "traces/generators.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

namespace {

using namespace ropsim;

// Takes choices and numbers from the input, zeros where it has ended.
class Choices {
 public:
    Choices(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}
    bool any() const { return at_ != end_; }
    std::uint32_t byte() { return at_ == end_ ? 0 : *at_++; }
    std::size_t below(std::size_t count) {
        const std::uint32_t high = byte();  // apart: operands have no order
        return (high << 8 | byte()) % count;
    }

 private:
    const std::uint8_t* at_;
    const std::uint8_t* end_;
};

// Every key that the machine reads, with its default as TOML spells it.
const std::map<std::string, std::string>& keys() {
    static const std::map<std::string, std::string> all = [] {
        Parameters parameters = hardware_parameters("desktop");
        // Some keys are read only beside others.
        for (const char* text :
             {"cache.organisation=separate", "cache.kibibytes=64", "cache.depth_kibibytes=16"})
            set_from_text(parameters, text, "--set");
        machine_config(parameters, "desktop");
        std::map<std::string, std::string> found;
        for (const auto& [key, resolved] : parameters.resolved()) found[key] = resolved.value;
        return found;
    }();
    return all;
}

// Words that any key with choices may take, and numbers at the ends of ranges.
constexpr const char* kValues[] = {"0",
                                   "1",
                                   "2",
                                   "3",
                                   "4",
                                   "7",
                                   "8",
                                   "16",
                                   "32",
                                   "33",
                                   "64",
                                   "100",
                                   "128",
                                   "256",
                                   "1000",
                                   "1024",
                                   "4096",
                                   "65536",
                                   "65537",
                                   "-1",
                                   "0.5",
                                   "1e300",
                                   "nan",
                                   "inf",
                                   "true",
                                   "false",
                                   "none",
                                   "delta",
                                   "best",
                                   "planes",
                                   "used",
                                   "separate",
                                   "shared",
                                   "quad",
                                   "pixel",
                                   "tile",
                                   "early",
                                   "late",
                                   "planar",
                                   "interleaved",
                                   "morton",
                                   "rows",
                                   "quads",
                                   "result",
                                   "spin",
                                   "gddr3",
                                   "gddr5",
                                   "gddr5x",
                                   "gddr6",
                                   "hbm2",
                                   "lpddr4",
                                   "",
                                   "32 64 128",
                                   "8",
                                   "open",
                                   "closed",
                                   "timeout",
                                   "fcfs",
                                   "fr_fcfs",
                                   "all_bank",
                                   "per_bank",
                                   "watermark",
                                   "snapshot",
                                   "9223372036854775807",
                                   "1000000",
                                   "16777216",
                                   "row bank column",
                                   "round_robin",
                                   "oldest"};

struct Configuration {
    RunOptions options;
    std::vector<std::string> given;  // keys
    bool unknown = false;            // one of them is no key
};

Configuration configuration(Choices& choices, const std::string& trace) {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const auto& [key, unused] : keys()) list.push_back(key);
        return list;
    }();
    Configuration c;
    c.options.trace = trace;
    c.options.error = false;
    const auto& techniques = technique_list();
    c.options.technique = techniques[choices.below(techniques.size())].name;
    const std::uint32_t fidelity = choices.byte();
    c.options.fidelity = fidelity % 16 == 15 ? Fidelity::kTimed
                         : fidelity % 4 == 0 ? Fidelity::kCount
                                             : Fidelity::kCached;
    const auto& presets = hardware_presets();
    c.options.hardware = presets[choices.below(presets.size())].name;
    while (choices.any() && c.given.size() < 24) {
        std::string key = names[choices.below(names.size())];
        const std::uint32_t how = choices.byte();
        if (how == 255) {
            key += "x";
            c.unknown = true;
        }
        const std::string value = how < 128   ? kValues[choices.below(std::size(kValues))]
                                  : how < 250 ? std::to_string(how - 128)
                                              : keys().at(names[choices.below(names.size())]);
        c.given.push_back(key);
        c.options.settings.push_back(key + "=" + value);
    }
    return c;
}

// Keys that leave work out, or fragments, change the image; every other must not.
bool keeps_image(const Configuration& c) {
    return std::ranges::none_of(c.given, [](const std::string& key) {
        return key.starts_with("skip.") || key == "pool.mebibytes" || key == "rop.partitions" ||
               key == "rop.partition_tiles";
    });
}

// Names of keys, whole, in what the user is told.
bool names_a_key(const Configuration& c, const std::string& said) {
    for (const std::string& key : c.given)
        if (said.find(key) != std::string::npos) return true;
    return std::ranges::any_of(keys(),
                               [&](const auto& key) { return said.find(key.first) != std::string::npos; });
}

const std::vector<float>& default_image(const RunOptions& options) {
    static std::map<std::string, std::vector<float>> images;
    auto found = images.find(options.technique);
    if (found == images.end()) {
        RunOptions plain = options;
        plain.settings.clear();
        plain.hardware = "desktop";
        plain.fidelity = Fidelity::kCount;
        found = images.emplace(options.technique, run_simulation(plain).image.values).first;
    }
    return found->second;
}

void simulate(const Configuration& c) {
    const RunResult result = run_simulation(c.options);
    if (!keeps_image(c) || result.pool_nodes_overflowed != 0) return;
    const std::vector<float>& expected = default_image(c.options);
    CHECK(result.image.values.size() == expected.size() &&
              std::equal(expected.begin(), expected.end(), result.image.values.begin(),
                         [](float a, float b) { return a == b || (a != a && b != b); }),
          "{}: another image than the default machine's", c.options.technique);
}

// SystemC elaborates once a process.
void simulate_in_child(const Configuration& c) {
    const pid_t child = ::fork();
    CHECK(child >= 0);
    if (child == 0) {
        // libFuzzer's alarm would end neither.
        ::signal(SIGALRM, SIG_DFL);
        ::alarm(50);
        fuzz::accepted([&] { simulate(c); });
        ::_exit(0);
    }
    int status = 0;
    while (::waitpid(child, &status, 0) < 0) CHECK(errno == EINTR);
    CHECK(WIFEXITED(status) && WEXITSTATUS(status) == 0, "a timed run ended with status {:#x}", status);
}

std::string small_trace() {
    RandomFragments options;
    options.width = 20;
    options.height = 12;
    options.count = 150;
    options.opaque = true;
    options.draws = 2;
    const std::string path = fuzz::scratch_path("config.trace");
    write_trace(path, random_header(options), random_fragments(options));
    return path;
}

// The message of a configuration that is refused before anything is simulated.
std::optional<std::string> refusal(const Configuration& c) {
    try {
        Parameters parameters = hardware_parameters(c.options.hardware);
        for (const std::string& setting : c.options.settings) set_from_text(parameters, setting, "--set");
        machine_config(parameters, c.options.hardware);
        parameters.close();
        return std::nullopt;
    } catch (const UserError& error) {
        return error.where() + ": " + error.what();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::string trace = small_trace();
    Choices choices(data, size);
    const Configuration c = configuration(choices, trace);
    const std::optional<std::string> refused = refusal(c);
    CHECK(!c.unknown || refused, "a key that there is not was taken");
    if (refused) {
        CHECK(names_a_key(c, *refused), "no key is named: {}", *refused);
        return 0;
    }
    if (c.options.fidelity == Fidelity::kTimed)
        simulate_in_child(c);
    else
        fuzz::accepted([&] { simulate(c); });
    return 0;
}
