#include "rop/nodes/insertion_probability.h"

#include "base/error.h"

namespace ropsim {

InsertionProbability::InsertionProbability(int bits, CoverageBits kind) : bits_(bits) {
    CHECK(bits >= 1 && bits <= kMaxBits, "{} coverage bits", bits);
    const auto side = static_cast<std::size_t>(bits) + 1;
    table_.assign(side * side, 1.0f);
    for (int s = 0; s <= bits; ++s) {
        const std::size_t row = static_cast<std::size_t>(s) * side;
        if (kind == CoverageBits::kStratified) {
            // The falling factorials' quotient, a factor at a time; it is 0 from t = s + 1 on.
            double hidden = 1;
            for (int t = 0; t <= s; ++t) {
                table_[row + static_cast<std::size_t>(t)] = static_cast<float>(1.0 - hidden);
                hidden *= static_cast<double>(s - t) / static_cast<double>(bits - t);
            }
            continue;
        }
        for (int t = 0; t <= bits; ++t) {
            // The power by repeated squaring: the C library's is not the same on all machines.
            double hidden = 1;
            double base = static_cast<double>(bits - t) / static_cast<double>(bits);
            for (int exponent = bits - s; exponent > 0; exponent /= 2) {
                if (exponent % 2 == 1) hidden *= base;
                base *= base;
            }
            table_[row + static_cast<std::size_t>(t)] = static_cast<float>(1.0 - hidden);
        }
    }
}

}  // namespace ropsim
