// Passes in the machine: see batch_watch.h.
#include "model/batch_watch.h"

#include <algorithm>

namespace ropsim {

QuadBatch* BatchWatch::next() {
    QuadBatch* batch = source_.next();
    if (batch == nullptr || batch->quads.empty()) return batch;
    if (passes_.empty() || batch->pass != pass_) {
        pass_ = batch->pass;
        passes_.push_back({names_[pass_], wheel_.now(), wheel_.now(), 0});
    }
    passes_.back().quads += batch->quads.size();
    inside_.emplace_back(batch, passes_.size() - 1);
    for (const QuadOperation& quad : batch->quads)
        rastered_ += quad.kind == QuadKind::kDraw || quad.kind == QuadKind::kCulled ? 1 : 0;
    reuse_.use(*batch);
    return batch;
}

void BatchWatch::release(QuadBatch* batch) {
    const auto found = std::ranges::find(inside_, batch, &std::pair<QuadBatch*, std::size_t>::first);
    if (found != inside_.end()) {
        PassSpan& pass = passes_[found->second];
        pass.end = std::max(pass.end, wheel_.now());
        inside_.erase(found);
    }
    const Picoseconds end = std::max(wheel_.now(), last_end_);
    added_time_[batch->pass] += end - last_end_;
    last_end_ = end;
    source_.release(batch);
}

std::vector<Picoseconds> BatchWatch::added_times(Picoseconds end) const {
    std::vector<Picoseconds> times = added_time_;
    times.back() += end - last_end_;
    return times;
}

}  // namespace ropsim
