// parallel_for: every piece once, failures as if run in order.
#include "base/parallel.h"

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(ParallelFor, RunsEveryPieceOnce) {
    for (const int threads : {-1, 0, 1, 2, 8})
        for (const int count : {0, 1, 2, 1000}) {
            std::vector<std::atomic<int>> runs(static_cast<std::size_t>(count));
            parallel_for(threads, count, [&](int i) { ++runs[static_cast<std::size_t>(i)]; });
            for (const auto& r : runs)
                ASSERT_EQ(r.load(), 1) << threads << " threads, " << count << " pieces";
        }
}

TEST(ParallelFor, RethrowsTheLowestFailingPiece) {
    for (const int threads : {1, 2, 8})
        for (int repeat = 0; repeat < 50; ++repeat) {
            std::string message;
            try {
                parallel_for(threads, 200, [](int i) {
                    if (i >= 17) throw std::runtime_error(std::to_string(i));
                });
            } catch (const std::runtime_error& error) {
                message = error.what();
            }
            ASSERT_EQ(message, "17") << threads << " threads";
        }
}

TEST(ParallelFor, ThereIsAtLeastOneThread) {
    EXPECT_GE(default_threads(), 1);
}

}  // namespace
}  // namespace ropsim
