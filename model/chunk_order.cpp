#include "model/chunk_order.h"

#include <utility>

namespace ropsim {

namespace {

template <class Value>
void permute_values(std::vector<Value>& values, const std::vector<std::uint32_t>& order) {
    if (values.empty()) return;
    std::vector<Value> permuted;
    permuted.reserve(order.size());
    for (const std::uint32_t i : order) permuted.push_back(values[i]);
    values = std::move(permuted);
}

}  // namespace

void permute(FragmentChunk& chunk, const std::vector<std::uint32_t>& order) {
    permute_values(chunk.fragments, order);
    permute_values(chunk.slopes, order);
    permute_values(chunk.materials, order);
}

}  // namespace ropsim
