// Reads value change dumps back: an independent parser of IEEE 1364's syntax, as strict as viewers are.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {

class VcdReader {
 public:
    struct Signal {
        int bits = 0;
        std::map<std::uint64_t, std::uint64_t> values;  // by time of change; unknown before the first
    };
    std::string timescale;
    std::map<std::string, Signal> signals;  // by name with its scopes
    std::uint64_t end = 0;

    explicit VcdReader(const std::string& text) : in_(text) {
        read_declarations();
        read_changes();
    }
    // The value that holds at `time`; a signal that is still unknown fails the test.
    std::uint64_t at(const std::string& name, std::uint64_t time) const {
        const Signal& signal = signals.at(name);
        auto next = signal.values.upper_bound(time);
        if (next == signal.values.begin()) {
            ADD_FAILURE() << name << " is unknown at " << time;
            return 0;
        }
        return std::prev(next)->second;
    }

 private:
    std::string word() {
        std::string w;
        in_ >> w;
        return w;
    }
    std::string until_end() {
        std::string all;
        for (std::string w = word(); w != "$end" && in_; w = word()) all += (all.empty() ? "" : " ") + w;
        return all;
    }
    void read_declarations() {
        std::vector<std::string> scopes;
        std::set<std::string> closed;
        for (std::string w = word(); in_; w = word()) {
            if (w == "$enddefinitions") {
                EXPECT_EQ(word(), "$end");
                EXPECT_TRUE(scopes.empty());
                return;
            }
            if (w == "$comment") {
                until_end();
            } else if (w == "$timescale") {
                timescale = until_end();
            } else if (w == "$scope") {
                EXPECT_EQ(word(), "module");
                scopes.push_back(word());
                EXPECT_EQ(word(), "$end");
                EXPECT_FALSE(closed.contains(path(scopes))) << path(scopes) << " is opened twice";
            } else if (w == "$upscope") {
                EXPECT_EQ(word(), "$end");
                closed.insert(path(scopes));
                scopes.pop_back();
            } else if (w == "$var") {
                EXPECT_EQ(word(), "wire");
                const int bits = std::stoi(word());
                const std::string code = word();
                for (const char c : code) EXPECT_TRUE(c >= '!' && c <= '~');
                const std::string name = path(scopes) + "." + word();
                EXPECT_EQ(word(), "$end");
                EXPECT_TRUE(codes_.emplace(code, name).second) << "code " << code << " twice";
                EXPECT_TRUE(signals.emplace(name, Signal{bits, {}}).second) << name << " twice";
            } else {
                ADD_FAILURE() << "declaration " << w;
            }
        }
    }
    void read_changes() {
        bool first = true;
        for (std::string w = word(); in_; w = word()) {
            if (w[0] == '#') {
                const std::uint64_t time = std::stoull(w.substr(1));
                EXPECT_TRUE(first || time >= end) << "time " << time << " after " << end;
                end = time;
                first = false;
            } else if (w != "$dumpvars" && w != "$end") {
                const bool vector = w[0] == 'b';
                const std::string value = vector ? w.substr(1) : w.substr(0, 1);
                const std::string code = vector ? word() : w.substr(1);
                Signal& signal = signals.at(codes_.at(code));
                EXPECT_EQ(vector, signal.bits != 1);
                EXPECT_LE(value.size(), static_cast<std::size_t>(signal.bits));
                if (value != "x") signal.values[end] = std::stoull(value, nullptr, 2);
            }
        }
    }
    static std::string path(const std::vector<std::string>& scopes) {
        std::string all;
        for (const std::string& s : scopes) all += (all.empty() ? "" : ".") + s;
        return all;
    }

    std::istringstream in_;
    std::map<std::string, std::string> codes_;
};

}  // namespace ropsim
