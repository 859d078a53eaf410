// Typed, ranged reads of key=value settings, where a key that nobody reads is an error with its place.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

// A flat set of dotted keys ("dram.banks") with the place each value came from. Reading a key marks it as
// known; close() then refuses whatever was given but never read. Defaults stand at the read, and every read
// is remembered with its resolved value, so that a run can print its whole configuration.
class Parameters {
 public:
    Parameters() = default;
    // `context` names the set in messages, e.g. "technique 'adaptive'" or "hardware preset 'desktop'".
    explicit Parameters(std::string context) : context_(std::move(context)) {}

    // Text "key=value,key=value"; `where` is the option it came from. Throws UserError on a malformed or
    // repeated key.
    static Parameters from_list(std::string context, std::string_view text, const std::string& where);
    // A TOML file; tables become dotted keys. Throws UserError with file and line.
    static Parameters from_toml_file(std::string context, const std::string& path);
    // TOML text, `name` standing for the file in messages.
    static Parameters from_toml_text(std::string context, std::string_view text, const std::string& name);

    // Adds or replaces one value (from --set key=value).
    void set(const std::string& key, const std::string& value, const std::string& where);
    // Adds the values of `other`, replacing those of the same key.
    void merge(const Parameters& other);

    // Each returns the given value or `fallback`; out of range or of the wrong type is a UserError.
    std::int64_t get_integer(const std::string& key, std::int64_t fallback, std::int64_t low,
                             std::int64_t high);
    double get_real(const std::string& key, double fallback, double low, double high);
    bool get_flag(const std::string& key, bool fallback);
    std::string get_string(const std::string& key, const std::string& fallback);
    // One of `choices`; anything else is a UserError that lists them.
    std::string get_choice(const std::string& key, const std::string& fallback,
                           std::initializer_list<std::string_view> choices);

    bool has(const std::string& key) const { return values_.count(key) != 0; }
    // "where: key" of a given key (its file and line or option), for a UserError about a combination of keys.
    std::string where(const std::string& key) const;
    const std::string& context() const { return context_; }

    // Refuses every key that was given but not read, naming its place and the nearest known key.
    void close() const;

    struct Resolved {
        std::string value;  // as text, TOML syntax
        bool given;         // false: the default
    };
    // All keys read so far with the values in force.
    const std::map<std::string, Resolved>& resolved() const { return resolved_; }

 private:
    struct Value {
        std::string text;
        std::string where;
    };
    const Value* find(const std::string& key);

    std::string context_;
    std::map<std::string, Value> values_;
    std::map<std::string, Resolved> resolved_;
};

}  // namespace ropsim
