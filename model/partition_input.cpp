#include "model/partition_input.h"

#include "model/front_end.h"

namespace ropsim {

void PartitionInput::pop() {
    if (++head_ == ring_.size()) head_ = 0;
    --count_;
    front_end_->partition_free(number_);
}

void PartitionInput::done() {
    front_end_->quad_done();
}

}  // namespace ropsim
