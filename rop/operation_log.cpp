#include "rop/operation_log.h"

namespace ropsim {

void OperationLog::make_room() {
    const std::size_t records = std::max<std::size_t>(1024, 2 * records_);
    paths_.resize(records);
    steps_.resize(records);
    accesses_.resize(records * surfaces_ + 1);  // one where there are no surfaces: its address is taken
}

void OperationLog::keep_values(const std::uint32_t* words, const PixelAccess& access, NodePool* pool) {
    for (std::size_t s = 0; s < surfaces_; ++s) {
        if (values_of_[s] == 0 || access[s].write == 0) continue;
        const Surface& surface = declaration_.surfaces[s];
        const std::size_t bytes = static_cast<std::size_t>(surface.element_bytes());
        const std::size_t first = values_.size();
        if (pool_[s]) {
            const std::uint32_t* node = pool->words(static_cast<std::uint32_t>(access[s].write));
            values_.resize(first + bytes);
            store_elements(surface, node + surface.first_word, 1, &values_[first]);
            continue;
        }
        values_.resize(first + count_elements(access[s].write) * bytes);
        store_elements(surface, words + surface.first_word, access[s].write, &values_[first]);
    }
}

}  // namespace ropsim
