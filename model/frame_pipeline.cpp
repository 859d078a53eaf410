#include "model/frame_pipeline.h"

#include <system_error>
#include <utility>

namespace ropsim {

FramePipeline::FramePipeline(Frame& frame, int threads)
    : FramePipeline([&frame](QuadBatch& batch) { return frame.advance(batch); }, threads) {}

FramePipeline::FramePipeline(std::function<bool(QuadBatch&)> advance, int threads)
    : advance_(std::move(advance)) {
    if (threads <= 1) return;
    try {
        producer_ = std::thread([this] { produce(); });
    } catch (const std::system_error&) {
        // The system gives no more threads: batches are made when they are asked for.
    }
}

FramePipeline::~FramePipeline() {
    if (!producer_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    producer_.join();
}

// Called with the lock held or without a producer.
QuadBatch* FramePipeline::take_empty() {
    if (empty_.empty()) {
        owned_.push_back(std::make_unique<QuadBatch>());
        return owned_.back().get();
    }
    QuadBatch* batch = empty_.back();
    empty_.pop_back();
    return batch;
}

void FramePipeline::produce() {
    for (;;) {
        QuadBatch* batch = nullptr;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [this] { return stopping_ || ready_.size() < kAhead; });
            if (stopping_) return;
            batch = take_empty();
        }
        bool more = false;
        std::exception_ptr failure;
        try {
            more = advance_(*batch);
        } catch (...) {
            failure = std::current_exception();
        }
        {
            const std::lock_guard lock(mutex_);
            if (more) ready_.push_back(batch);
            ended_ = !more;
            failure_ = failure;
        }
        changed_.notify_all();
        if (!more) return;
    }
}

QuadBatch* FramePipeline::next() {
    if (!producer_.joinable()) {
        QuadBatch* batch = take_empty();
        if (advance_(*batch)) return batch;
        empty_.push_back(batch);
        return nullptr;
    }
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return ended_ || !ready_.empty(); });
    if (failure_) std::rethrow_exception(failure_);
    if (ready_.empty()) return nullptr;
    QuadBatch* batch = ready_.front();
    ready_.pop_front();
    lock.unlock();
    changed_.notify_all();
    return batch;
}

void FramePipeline::release(QuadBatch* batch) {
    const std::lock_guard lock(mutex_);
    empty_.push_back(batch);
}

}  // namespace ropsim
