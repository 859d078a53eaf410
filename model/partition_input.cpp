#include "model/partition_input.h"

#include "model/front_end.h"

namespace ropsim {

void PartitionInput::pop() {
    if (++head_ == ring_.size()) head_ = 0;
    --count_;
    // The next quad's lines have not been looked at since they were written: they come while this quad's are
    // looked up.
    if (count_ != 0) {
        const QuadOperation& next = front().batch->quads[front().quad];
        const LineAccess* lines = front().batch->lines[next.partition].data() + next.first_line;
        __builtin_prefetch(lines);
        __builtin_prefetch(lines + 1);
        __builtin_prefetch(lines + 2);
    }
    front_end_->partition_free(number_);
}

void PartitionInput::done(std::uint32_t warp) {
    front_end_->quad_done(warp);
}

}  // namespace ropsim
