// Runs the functional frame ahead of the timing, on a thread of its own where there is a core for it.
#pragma once

#include "model/frame.h"
#include "model/quad_operation.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace ropsim {

// Batches come in the same order with the same content whatever `threads` is. Batches are recycled when
// released.
class FramePipeline : public BatchSource {
 public:
    FramePipeline(Frame& frame, int threads);
    // Of what makes a frame's batches in another order.
    FramePipeline(std::function<bool(QuadBatch&)> advance, int threads);
    ~FramePipeline() override;
    QuadBatch* next() override;
    void release(QuadBatch* batch) override;

 private:
    static constexpr std::size_t kAhead = 2;  // batches run before they are asked for
    QuadBatch* take_empty();
    void produce();

    std::function<bool(QuadBatch&)> advance_;
    std::vector<std::unique_ptr<QuadBatch>> owned_;
    std::vector<QuadBatch*> empty_;
    std::deque<QuadBatch*> ready_;
    bool ended_ = false;
    bool stopping_ = false;
    std::exception_ptr failure_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::thread producer_;
};

}  // namespace ropsim
