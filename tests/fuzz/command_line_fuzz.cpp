// Fuzzes command lines, an argument a line. Every one is parsed; those of commands that need no OpenGL and
// little work are then run, in a folder with a small input of each kind. Each ends well, or in words that a
// user can read: one line of ours, or what the parser says with exit code 2.
#include "cli/command_line.h"
#include "rop/reference.h"
#include "tests/fuzz/fuzz_input.h"
#include "traces/generators.h"
#include "traces/image.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

namespace {

using namespace ropsim;
namespace fs = std::filesystem;
using Words = std::vector<std::string>;

// What every command finds in its working directory.
void write_inputs(const std::string& folder) {
    RandomFragments options;
    options.width = 12;
    options.height = 9;
    options.count = 80;
    options.opaque = true;
    options.draws = 2;
    write_trace(folder + "/t.trace", random_header(options), random_fragments(options));
    TraceReader trace(folder + "/t.trace");
    write_exr(folder + "/i.exr", reference_image(trace, 1));
    std::ofstream(folder + "/f.csv")
        << "# size 4x3\nx,y,z,r,g,b,a\n1,1,0.5,1,0.5,0.25,0.75\n2,1,0.25,0,0,1,0.5\n";
    std::ofstream(folder + "/a.txt") << "0x1000 READ 0\n0x2040 WRITE 5\n0x1000 READ 9\n";
    std::ofstream(folder + "/h.toml") << "rop.lanes = 2\ndram.device = \"gddr5\"\n";
}

// Moves into a folder that holds nothing but the inputs.
void enter_fresh_folder() {
    static const std::string inputs = [] {
        const std::string folder = fuzz::scratch_path("inputs");
        fs::create_directory(folder);
        // References go with the rest.
        ::setenv("XDG_CACHE_HOME", fuzz::scratch_path("cache").c_str(), 1);
        write_inputs(folder);
        return folder;
    }();
    const std::string folder = fuzz::scratch_path("working");
    fs::remove_all(folder);
    fs::create_directory(folder);
    for (const auto& file : fs::directory_iterator(inputs))
        fs::copy_file(file.path(), folder + "/" + file.path().filename().string());
    fs::current_path(folder);
}

Words words_of(const std::uint8_t* data, std::size_t size) {
    Words words;
    std::istringstream lines(std::string(reinterpret_cast<const char*>(data), size));
    for (std::string line; words.size() < 24 && std::getline(lines, line);) {
        std::erase(line, '\0');  // no argument of a program holds one
        words.push_back(std::move(line));
    }
    return words;
}

constexpr unsigned kSecondsOfChild = 50;

struct Parsed {};  // ends parsing before the command is run

// Whether the words are a command line, without running it.
bool is_command_line(const Words& words) {
    const std::unique_ptr<CLI::App> app = make_command_line();
    // The commands' own callbacks hold their options: they must stay.
    app->parse_complete_callback([] { throw Parsed{}; });
    try {
        app->parse(Words(words.rbegin(), words.rend()));
    } catch (const Parsed&) {
        return true;
    } catch (const CLI::ParseError& error) {
        std::ostringstream out, err;
        const int status = app->exit(error, out, err);
        CHECK(status == 0 ? !out.str().empty() : !err.str().empty(), "nothing is said of {}", error.what());
        return false;
    }
    CHECK(false, "parsed, and nothing was called");
}

// Four digits are work, and `1e9` would be.
bool is_small(std::string_view word) {
    int digits = 0;
    bool number = false;  // what is before an `e` ends in a digit
    for (const char c : word) {
        const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
        if ((digit && ++digits > 3) || (number && (c == 'e' || c == 'E'))) return false;
        if (!digit) digits = 0;
        number = digit || c == '.';
    }
    return true;
}

enum class Place { kNowhere, kHere, kChild };

bool has(const Words& words, std::string_view word) {
    return std::ranges::find(words, word) != words.end();
}

// SystemC elaborates once a process. A path with a slash could be anywhere on this machine.
Place place_of(const Words& words) {
    if (words.empty() || !std::ranges::all_of(words, [](const std::string& w) {
            return is_small(w) && w.find('/') == std::string::npos && w.find("..") == std::string::npos;
        }))
        return Place::kNowhere;
    const std::string& command = words[0];
    if (command == "list" || command == "cost" || command == "diff" || command == "reference" ||
        command == "trace")
        return Place::kHere;
    // Untold, a pattern has a million requests.
    if (command == "memory") return has(words, "--pattern") ? Place::kNowhere : Place::kChild;
    if (command == "run") return Place::kChild;
    return Place::kNowhere;
}

void run(const Words& words) {
    std::vector<const char*> argv = {"ropsim"};
    for (const std::string& word : words) argv.push_back(word.c_str());
    fuzz::accepted([&] {
        const int status = run_command_line(static_cast<int>(argv.size()), argv.data());
        CHECK(status == 0 || status == 2, "exit code {}", status);
    });
}

void run_in_child(const Words& words) {
    const pid_t child = ::fork();
    CHECK(child >= 0);
    if (child == 0) {
        // libFuzzer's alarm would end neither.
        ::signal(SIGALRM, SIG_DFL);
        ::alarm(kSecondsOfChild);
        run(words);
        ::_exit(0);
    }
    int status = 0;
    while (::waitpid(child, &status, 0) < 0) CHECK(errno == EINTR);
    CHECK(WIFEXITED(status) && WEXITSTATUS(status) == 0, "ended with status {:#x}", status);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const Words words = words_of(data, size);
    if (!is_command_line(words)) return 0;
    const Place place = place_of(words);
    if (place == Place::kNowhere) return 0;
    // libFuzzer's own paths are relative to where it began.
    static const fs::path began = fs::current_path();
    enter_fresh_folder();
    if (place == Place::kHere)
        run(words);
    else
        run_in_child(words);
    fs::current_path(began);
    return 0;
}
