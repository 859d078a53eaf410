// The order in which a technique's passes run, rounds of repeated ones included.
#pragma once

#include "rop/declaration.h"

#include <cstdint>

namespace ropsim {

class PassSequence {
 public:
    explicit PassSequence(const Declaration& declaration) : declaration_(&declaration) {}

    bool done() const { return pass_ >= static_cast<int>(declaration_->passes.size()); }
    int pass() const { return pass_; }
    int round() const { return round_; }  // of the repeated passes, from 0; 0 outside them
    const Pass& current() const { return declaration_->passes[static_cast<std::size_t>(pass_)]; }
    // The path whose use in a round asks for another round; -1 for none.
    int watched_path() const { return declaration_->repeat.path; }

    // Goes on to the next pass. `taken`: how often the watched path has been taken so far, in all rounds.
    void advance(std::uint64_t taken) {
        const Repeat& repeat = declaration_->repeat;
        if (pass_ == repeat.last) {
            const bool wanted = repeat.path < 0 || taken > taken_before_;
            taken_before_ = taken;
            if (wanted && round_ + 1 < repeat.rounds) {
                pass_ = repeat.first;
                ++round_;
                return;
            }
            round_ = 0;
        }
        ++pass_;
    }

 private:
    const Declaration* declaration_;
    int pass_ = 0;
    int round_ = 0;
    std::uint64_t taken_before_ = 0;
};

}  // namespace ropsim
