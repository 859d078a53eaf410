// Typed, ranged reads of key=value settings, where a key that nobody reads is an error with its place.
#include "base/parameters.h"

#include "base/atomic_file.h"
#include "base/edit_distance.h"
#include "base/error.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/ranges.h>
#include <toml++/toml.h>

namespace ropsim {

namespace {

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

// The whole text as a number of type T, or nothing.
template <typename T>
std::optional<T> parse_number(std::string_view text) {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

// A real number as TOML spells it: shortest text that reads back the same, never mistaken for an integer.
std::string real_text(double value) {
    std::string text = fmt::format("{}", value);
    if (text.find_first_of(".einf") == std::string::npos) text += ".0";
    return text;
}

std::string toml_string(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            result += '\\';
            result += c;
        } else if (static_cast<unsigned char>(c) < 0x20) {
            result += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
        } else {
            result += c;
        }
    }
    return result + '"';
}

// How to mend an unknown key: the nearest known one, or all of them where none is near.
std::string hint(const std::string& key, const std::map<std::string, Parameters::Resolved>& known) {
    if (known.empty()) return "it takes no keys";
    const std::string* nearest = nullptr;
    std::size_t nearest_distance = 0;
    std::vector<std::string_view> names;
    for (const auto& [name, unused] : known) {
        const std::size_t distance = edit_distance(key, name);
        if (!nearest || distance < nearest_distance) {
            nearest = &name;
            nearest_distance = distance;
        }
        names.push_back(name);
    }
    if (nearest_distance <= std::max<std::size_t>(2, key.size() / 3))
        return fmt::format("did you mean {}?", *nearest);
    return fmt::format("the keys are {}", fmt::join(names, ", "));
}

// The text of a TOML leaf; nothing for arrays and dates, which no key takes.
std::optional<std::string> leaf_text(const toml::node& node) {
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* integer = node.as_integer()) return fmt::format("{}", integer->get());
    if (const auto* real = node.as_floating_point()) return real_text(real->get());
    if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
    return std::nullopt;
}

void add_table(Parameters& parameters, const toml::table& table, const std::string& prefix,
               const std::string& name) {
    for (const auto& [key, node] : table) {
        const std::string full = prefix + std::string(key.str());
        const std::string place = fmt::format("{}:{}", name, node.source().begin.line);
        if (const auto* inner = node.as_table()) {
            add_table(parameters, *inner, full + ".", name);
        } else if (const auto text = leaf_text(node)) {
            parameters.set(full, *text, place);
        } else {
            throw UserError(place, fmt::format("{}: must be one number, string or true/false", full));
        }
    }
}

}  // namespace

Parameters Parameters::from_list(std::string context, std::string_view text, const std::string& where) {
    Parameters result(std::move(context));
    while (!text.empty()) {
        const std::size_t comma = text.find(',');
        const std::string_view item = text.substr(0, comma);
        text = comma == std::string_view::npos ? std::string_view{} : text.substr(comma + 1);
        const std::size_t equals = item.find('=');
        const std::string key{trimmed(item.substr(0, equals))};
        if (equals == std::string_view::npos || key.empty())
            throw UserError(where, fmt::format("'{}' is not key=value; write key=value,key=value", item));
        if (result.has(key)) throw UserError(where, fmt::format("{} is given twice; keep one", key));
        result.set(key, std::string(trimmed(item.substr(equals + 1))),
                   result.context_.empty() ? where : result.context_);
    }
    return result;
}

Parameters Parameters::from_toml_file(std::string context, const std::string& path) {
    return from_toml_text(std::move(context), read_file(path), path);
}

Parameters Parameters::from_toml_text(std::string context, std::string_view text, const std::string& name) {
    Parameters result(std::move(context));
    try {
        add_table(result, toml::parse(text, name), "", name);
    } catch (const toml::parse_error& error) {
        throw UserError(fmt::format("{}:{}", name, error.source().begin.line),
                        fmt::format("not valid TOML: {}", error.description()));
    }
    return result;
}

void Parameters::set(const std::string& key, const std::string& value, const std::string& where) {
    values_[key] = Value{value, where};
}

void Parameters::merge(const Parameters& other) {
    for (const auto& [key, value] : other.values_) values_[key] = value;
}

const Parameters::Value* Parameters::find(const std::string& key) {
    const auto found = values_.find(key);
    return found == values_.end() ? nullptr : &found->second;
}

std::int64_t Parameters::get_integer(const std::string& key, std::int64_t fallback, std::int64_t low,
                                     std::int64_t high) {
    const Value* given = find(key);
    const auto value = given ? parse_number<std::int64_t>(given->text) : fallback;
    resolved_[key] = {fmt::format("{}", value.value_or(fallback)), given != nullptr};
    if (given && (!value || *value < low || *value > high))
        throw UserError(where(key), fmt::format("must be an integer from {} to {}", low, high));
    return *value;
}

double Parameters::get_real(const std::string& key, double fallback, double low, double high) {
    const Value* given = find(key);
    const auto value = given ? parse_number<double>(given->text) : fallback;
    resolved_[key] = {real_text(value.value_or(fallback)), given != nullptr};
    if (given && (!value || !(*value >= low && *value <= high)))  // a NaN is in no range
        throw UserError(where(key), fmt::format("must be a number from {} to {}", low, high));
    return *value;
}

bool Parameters::get_flag(const std::string& key, bool fallback) {
    const Value* given = find(key);
    const bool value = given ? given->text == "true" || given->text == "on" : fallback;
    resolved_[key] = {value ? "true" : "false", given != nullptr};
    if (given && !value && given->text != "false" && given->text != "off")
        throw UserError(where(key), "must be true or false");
    return value;
}

std::string Parameters::get_string(const std::string& key, const std::string& fallback) {
    const Value* given = find(key);
    const std::string& value = given ? given->text : fallback;
    resolved_[key] = {toml_string(value), given != nullptr};
    return value;
}

std::string Parameters::get_choice(const std::string& key, const std::string& fallback,
                                   std::initializer_list<std::string_view> choices) {
    std::string value = get_string(key, fallback);
    if (has(key) && std::find(choices.begin(), choices.end(), value) == choices.end())
        throw UserError(where(key), fmt::format("must be one of {}", fmt::join(choices, ", ")));
    return value;
}

std::string Parameters::where(const std::string& key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return context_.empty() ? key : fmt::format("{}: {}", context_, key);
    return fmt::format("{}: {}={}", found->second.where, key, found->second.text);
}

void Parameters::close() const {
    for (const auto& [key, value] : values_) {
        if (resolved_.count(key)) continue;
        // A list's values have the context itself as their place: it need not be said twice.
        const bool placed = value.where != context_ && !context_.empty();
        throw UserError(fmt::format("{}: {}", value.where, key),
                        fmt::format("{}; {}", placed ? context_ + " has no such key" : "no such key",
                                    hint(key, resolved_)));
    }
}

}  // namespace ropsim
