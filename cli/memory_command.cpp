// `ropsim memory`: the DRAM alone, on an address trace or a pattern.
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "cli/commands.h"
#include "cli/memory_report.h"
#include "memory/access_pattern.h"
#include "memory/address_trace.h"
#include "memory/memory_run.h"
#include "model/machine_config.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace ropsim {
namespace {

constexpr std::uint64_t kDefaultSpan = std::uint64_t{1} << 30;

constexpr const char* kExplanation =
    "An address trace has a line '0xADDRESS READ|WRITE CYCLE' for each request: offered in order, as fast as "
    "the\n"
    "controllers accept them, none before its CYCLE. The stream waits while its next request finds no room.\n"
    "Bandwidth is useful bytes over the time from cycle 0 to the last data; its percentage is of the pins' "
    "peak,\n"
    "bus bits x transfers a second of all channels. Keys of --set: dram.* (the device's), memory.channels,\n"
    "memory.channel_bits, memory.request_bytes, and memory.bank_bits, bankgroup_bits, rank_bits, "
    "pseudochannel_bits.";

struct MemoryOptions {
    std::string addresses;
    std::string pattern;
    std::string device = "gddr6";
    std::vector<std::string> settings;
    std::uint64_t requests = 1'000'000;
    std::uint64_t span = 0;
    std::uint32_t outstanding = 0;
    std::string recorded;
    bool json = false;
};

// A trace of what was simulated, complete or not there at all.
class TraceRecorder {
 public:
    explicit TraceRecorder(const std::string& path)
        : atomic_(path), file_(std::fopen(atomic_.temporary_path().c_str(), "wb")) {
        if (file_ == nullptr) fail();
    }
    void add(const std::vector<AddressRequest>& block) {
        text_.clear();
        for (const AddressRequest& request : block) append_trace_line(text_, request);
        if (std::fwrite(text_.data(), 1, text_.size(), file_.get()) != text_.size()) fail();
    }
    void finish() {
        if (std::fclose(file_.release()) != 0) fail();
        atomic_.commit();
    }

 private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    [[noreturn]] void fail() const {
        throw UserError(atomic_.path(), fmt::format("cannot be written: {}", std::strerror(errno)));
    }
    AtomicFile atomic_;
    std::unique_ptr<std::FILE, Close> file_;
    std::string text_;
};

// The requests, and the largest distance to one that another needs.
struct Stream {
    std::unique_ptr<RequestSource> source;
    std::uint32_t needs = 0;
};

Stream open_stream(const MemoryOptions& options, const MemoryConfig& config) {
    if (options.pattern.empty()) return {std::make_unique<AddressTraceReader>(options.addresses), 0};
    const std::uint64_t capacity = config.channels * config.dram.capacity_bytes();
    PatternOptions pattern;
    pattern.name = options.pattern;
    pattern.requests = options.requests;
    pattern.bytes = config.request_bytes;
    pattern.span = options.span != 0 ? options.span : std::min(kDefaultSpan, capacity);
    if (options.span == 0) pattern.span -= pattern.span % pattern.bytes;
    if (pattern.span > capacity)
        throw UserError("--span", fmt::format("{} bytes, but the memory holds {}", pattern.span, capacity));
    return {std::make_unique<AccessPattern>(pattern), AccessPattern::kNeeds};
}

void memory(const MemoryOptions& options) {
    if (options.addresses.empty() && options.pattern.empty())
        throw CLI::ValidationError("ropsim memory", "give a file of addresses or --pattern NAME");
    if (!options.addresses.empty() && !options.pattern.empty())
        throw CLI::ValidationError("ropsim memory", "give a file of addresses or --pattern NAME, not both");
    Parameters parameters("memory");
    parameters.set("dram.device", options.device, "--device");
    for (const std::string& setting : options.settings) set_from_text(parameters, setting, "--set");
    const MemoryConfig config = memory_config(parameters);
    parameters.close();
    const Stream stream = open_stream(options, config);
    MemoryRunOptions run_options;
    run_options.outstanding = options.outstanding;
    run_options.needs = stream.needs;
    std::unique_ptr<TraceRecorder> recorder;
    if (!options.recorded.empty()) {
        keep_inputs({options.addresses}, {options.recorded});
        recorder = std::make_unique<TraceRecorder>(options.recorded);
        run_options.record = [&](const std::vector<AddressRequest>& block) { recorder->add(block); };
    }
    const MemoryRun run = run_memory(config, *stream.source, run_options);
    if (recorder) recorder->finish();
    if (run.wrapped_requests != 0)
        fmt::print(stderr, "{} of {} requests have addresses over the capacity of {} MiB; they wrap around\n",
                   run.wrapped_requests, run.requests, run.capacity >> 20);
    fmt::print("{}", options.json ? memory_run_json(run, config, parameters) : memory_run_text(run, config));
}

}  // namespace

void add_memory_command(CLI::App& app) {
    auto options = std::make_shared<MemoryOptions>();
    CLI::App* command = app.add_subcommand("memory", "Simulates the DRAM alone, on an address trace");
    command->footer(kExplanation);
    command->add_option("addresses", options->addresses, "Address trace; /dev/stdin reads a pipe");
    command->add_option("--pattern", options->pattern, "A made stream instead of a trace")
        ->check(CLI::IsMember(pattern_names()));
    command->add_option(
        "--device", options->device,
        fmt::format("{} (`ropsim list devices`), or a .toml file", fmt::join(dram_device_names(), ", ")));
    command->add_option("--set", options->settings, "A key=value of the memory, repeatable")
        ->expected(1)
        ->take_all();
    command->add_option("--requests", options->requests, "Requests of a pattern")
        ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40));
    command->add_option("--span", options->span, "Bytes that a pattern runs over; 0: 1 GiB or the capacity")
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 60));
    command
        ->add_option("--outstanding", options->outstanding,
                     "A request needs the data of the one this many before it; 0: none does")
        ->check(CLI::Range(0u, 1u << 16));
    command->add_option("--write-trace", options->recorded, "Writes what was simulated as an address trace");
    command->add_flag("--json", options->json, "As JSON on stdout");
    command->callback([options] { memory(*options); });
}

}  // namespace ropsim
