// The list of lines by last use, with a mark where each capacity ends.
#include "memory/lru_stack.h"

#include "base/error.h"

#include <utility>

namespace ropsim {

LruStack::LruStack(std::vector<std::uint32_t> capacities)
    : capacities_(std::move(capacities)), last_of_level_(capacities_.size(), kNone) {
    CHECK(!capacities_.empty() && capacities_.size() <= 254, "{} capacities", capacities_.size());
    std::uint32_t before = 0;
    for (const std::uint32_t capacity : capacities_) {
        CHECK(capacity > before, "capacity {} after {}", capacity, before);
        before = capacity;
    }
}

void LruStack::push_front(std::uint32_t line) {
    Node& node = nodes_[line];
    node.newer = kNone;
    node.older = newest_;
    node.level = 0;
    if (newest_ != kNone) nodes_[newest_].newer = line;
    newest_ = line;
    if (oldest_ == kNone) oldest_ = line;
}

// The last line of the level has come to lie one place behind it.
void LruStack::sink(std::size_t level) {
    std::uint32_t& last = last_of_level_[level];
    nodes_[last].level = static_cast<int>(level) + 1;
    last = nodes_[last].newer;
}

int LruStack::use(std::uint32_t line) {
    const auto levels = static_cast<int>(capacities_.size());
    if (line >= nodes_.size()) nodes_.resize(std::size_t{line} + line / 2 + 1);
    Node& node = nodes_[line];
    if (node.level < 0) {
        push_front(line);
        ++count_;
        for (std::size_t l = 0; l < capacities_.size(); ++l) {
            if (last_of_level_[l] == kNone) {
                if (count_ == capacities_[l]) last_of_level_[l] = oldest_;
                break;
            }
            sink(l);
        }
        return levels;
    }
    const int level = node.level;
    if (line == newest_) return level;
    if (level < levels && last_of_level_[static_cast<std::size_t>(level)] == line)
        last_of_level_[static_cast<std::size_t>(level)] = node.newer;
    nodes_[node.newer].older = node.older;
    if (node.older != kNone)
        nodes_[node.older].newer = node.newer;
    else
        oldest_ = node.newer;
    push_front(line);
    for (int l = 0; l < level; ++l) sink(static_cast<std::size_t>(l));
    return level;
}

}  // namespace ropsim
