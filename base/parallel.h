// Runs independent pieces of work on all cores.
#pragma once

#include <functional>

namespace ropsim {

// Calls work(i) for i in [0, count) on up to `threads` threads (the caller is one of them) and returns when
// all are done. Pieces are handed out in order; results must not depend on which thread ran them. The first
// exception thrown by a piece is rethrown here. threads <= 1 runs in the caller.
void parallel_for(int threads, int count, const std::function<void(int)>& work);

// Threads to use when the user gave none: the machine's cores.
int default_threads();

}  // namespace ropsim
