// Address patterns: see access_pattern.h.
#include "memory/access_pattern.h"

#include "base/error.h"
#include "base/random.h"

#include <algorithm>

#include <fmt/ranges.h>

namespace ropsim {
namespace {

constexpr std::uint64_t kSeed = 20240607;
constexpr std::uint64_t kStride = 4096;
constexpr std::size_t kBlock = 8192;  // requests made at once

std::uint64_t splitmix(std::uint64_t state) {
    return mix64(state + 0x9E3779B97F4A7C15ull);
}

}  // namespace

const std::vector<std::string>& pattern_names() {
    static const std::vector<std::string> names = {"seq_read",  "rand_read",  "seq_write", "rand_write",
                                                   "seq_mix50", "rand_mix50", "chase",     "stride_rmw"};
    return names;
}

AccessPattern::AccessPattern(PatternOptions options) : options_(std::move(options)) {
    const std::string& name = options_.name;
    if (std::find(pattern_names().begin(), pattern_names().end(), name) == pattern_names().end())
        throw UserError("--pattern",
                        fmt::format("no pattern '{}'; one of {}", name, fmt::join(pattern_names(), ", ")));
    strided_ = name == "stride_rmw";
    random_ = name.starts_with("rand") || name == "chase";
    write_ = name.ends_with("write");
    mixed_ = name.ends_with("mix50");
    needs_ = name == "chase" ? 1 : 0;
    const std::uint64_t least = strided_ ? kStride : options_.bytes;
    if (options_.span < least || options_.span % options_.bytes != 0)
        throw UserError("--span",
                        fmt::format("{} bytes: must be a multiple of the request's {} and at least {}",
                                    options_.span, options_.bytes, least));
    blocks_ = options_.span / options_.bytes;
}

AddressRequest AccessPattern::request(std::uint64_t i) const {
    if (strided_) return strided(i);
    AddressRequest request;
    request.address = (random_ ? splitmix(kSeed + i) : i) % blocks_ * options_.bytes;
    request.write = mixed_ ? (splitmix(kSeed ^ (i * 7919)) >> 17 & 1) != 0 : write_;
    request.needs = i == 0 ? 0 : needs_;
    return request;
}

AddressRequest AccessPattern::strided(std::uint64_t i) const {
    const std::uint64_t pairs = options_.requests / 2;
    const std::uint64_t window = std::min<std::uint64_t>(options_.window, pairs);
    AddressRequest request;
    std::uint64_t pair = i;
    if (i >= window) {
        // writes and reads in turn until the reads are used up, then the last writes
        const std::uint64_t turn = i - window;
        const bool reads_left = turn < 2 * (pairs - window);
        request.write = !reads_left || turn % 2 == 0;
        pair = !reads_left ? turn - (pairs - window) : request.write ? turn / 2 : window + turn / 2;
        const std::uint64_t read_at = pair < window ? pair : 2 * pair - window + 1;
        if (request.write) request.needs = static_cast<std::uint32_t>(i - read_at);
    }
    request.address = pair * kStride % options_.span;
    return request;
}

bool AccessPattern::next(std::vector<AddressRequest>& block) {
    block.clear();
    const std::uint64_t total = strided_ ? options_.requests / 2 * 2 : options_.requests;
    const std::uint64_t end = std::min<std::uint64_t>(total, made_ + kBlock);
    while (made_ < end) block.push_back(request(made_++));
    return !block.empty();
}

}  // namespace ropsim
