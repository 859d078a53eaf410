// Runs independent pieces of work on all cores.
#include "base/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace ropsim {

namespace {

// The counter that hands out pieces, and the failure to rethrow.
struct Pieces {
    explicit Pieces(int n) : count(n) {}

    void run(const std::function<void(int)>& work) {
        while (!failed.load(std::memory_order_relaxed)) {
            const int piece = next.fetch_add(1, std::memory_order_relaxed);
            if (piece >= count) return;
            try {
                work(piece);
            } catch (...) {
                const std::lock_guard<std::mutex> lock(mutex);
                // Pieces are handed out in order, so every piece below a failing one has run: the lowest
                // failing piece, and with it the message the user sees, does not depend on the threads.
                if (!failure || piece < failed_piece) {
                    failure = std::current_exception();
                    failed_piece = piece;
                }
                failed = true;
            }
        }
    }

    const int count;
    std::atomic<int> next{0};
    std::atomic<bool> failed{false};
    std::mutex mutex;
    std::exception_ptr failure;
    int failed_piece = 0;
};

}  // namespace

void parallel_for(int threads, int count, const std::function<void(int)>& work) {
    if (threads <= 1 || count <= 1) {
        for (int i = 0; i < count; ++i) work(i);
        return;
    }
    Pieces pieces(count);
    {
        std::vector<std::jthread> helpers;
        const int helper_count = std::min(threads, count) - 1;
        helpers.reserve(static_cast<std::size_t>(helper_count));
        try {
            for (int i = 0; i < helper_count; ++i) helpers.emplace_back([&] { pieces.run(work); });
        } catch (const std::system_error&) {
            // The system gives no more threads (their number or memory is limited): those there do the work.
        }
        pieces.run(work);
    }
    if (pieces.failure) std::rethrow_exception(pieces.failure);
}

int default_threads() {
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace ropsim
