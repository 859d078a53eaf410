// Runs a technique's passes on a test's frame and counts those over the fragments.
#pragma once

#include "tests/rop/random_fragments.h"

#include <span>

namespace ropsim::test {

// Runs every pass; how many went over the fragments.
inline int draw_counting(TestFrame& frame, std::span<const Fragment> fragments) {
    PassSequence sequence(frame.declaration());
    int passes = 0;
    while (!sequence.done()) {
        if (sequence.current().kind == PassKind::kImage) {
            frame.image_pass(sequence.pass(), sequence.round());
        } else {
            frame.draw_pass(sequence.pass(), fragments, sequence.round());
            ++passes;
        }
        const int watched = sequence.watched_path();
        sequence.advance(watched < 0 ? 0 : frame.log().path_count(static_cast<std::size_t>(watched)));
    }
    return passes;
}

}  // namespace ropsim::test
