#include "model/partition_input.h"

#include "model/front_end.h"

namespace ropsim {

void PartitionInput::pop() {
    if (++head_ == places_) head_ = 0;
    --count_;
    // The next quad's lines have not been looked at since they were written: they come while this quad's are
    // looked up.
    if (count_ != 0) {
        const QuadOperation& next = front().batch->quads[front().quad];
        const auto& lines = front().batch->lines[next.partition];
        if (next.line_count != 0)
            for (std::uint32_t l = 0; l < 3; ++l) __builtin_prefetch(lines.data() + next.first_line + l);
    }
    front_end_->partition_free(number_);
}

void PartitionInput::done(std::uint32_t warp) {
    front_end_->quad_done(warp);
}

}  // namespace ropsim
