// The maps of the paper and their inverses.
#include "rop/visibility/moment_quantisation.h"

#include "base/error.h"

#include <cmath>
#include <utility>

namespace ropsim {

namespace {
using DoubleMatrix = std::array<std::array<double, kMaxMomentOrder>, kMaxMomentOrder>;

struct Map {
    DoubleMatrix odd;
    DoubleMatrix even;
    std::array<double, kMaxMomentOrder> even_offset;  // odd ones: 1/2
};

// Rows give a stored number from moments 1, 3, 5, 7 or 2, 4, 6, 8.
constexpr Map kFour = {
    {{{1.5, -2.0}, {0.86602540378443865, -0.38490017945975051}}}, {{{4.0, -4.0}, {0.5, 0.5}}}, {0.0, 0.0}};
constexpr Map kSix = {
    {{{2.5, -10.0, 8.0},
      {-1.87499864450, 4.20757543111, -1.83257678661},
      {1.26583039016, -1.47644882902, 0.71061660238}}},
    {{{4.0, -4.0, 0.0}, {9.0, -24.0, 16.0}, {-0.57759806484, 4.61936647543, -3.07953906655}}},
    {0.0, 0.0, 0.018888946}};
constexpr Map kEight = {{{{3.48044635732474, -27.5760737514826, 55.1267384344761, -31.5311110403183},
                          {1.26797185782836, -0.928755808743913, -2.07520453231032, 1.23598848322588},
                          {-2.1671560004294, 6.17950199592966, -0.276515571579297, -4.23583042392097},
                          {0.974332879165755, -0.443426830933027, -0.360491648368785, 0.310149466050223}}},
                        {{{0.280504133158527, -0.757633844606942, 0.392179589334688, -0.887531871812237},
                          {-2.01362265883247, 0.221551373038988, -1.06107954265125, 2.83887201588367},
                          {-7.31010494985321, 13.9855979699139, -0.114305766176437, -7.4361899359832},
                          {-15.8954215629556, 79.6186327084103, -127.457278992502, 63.7349456687829}}},
                        {0.972481993925964, 1.0, 0.999179192513328, 0.991778293073131}};

// By Gauss and Jordan, with pivots.
DoubleMatrix inverse(DoubleMatrix m, std::size_t n) {
    DoubleMatrix result{};
    for (std::size_t i = 0; i < n; ++i) result[i][i] = 1.0;
    for (std::size_t column = 0; column < n; ++column) {
        std::size_t pivot = column;
        for (std::size_t row = column + 1; row < n; ++row)
            if (std::abs(m[row][column]) > std::abs(m[pivot][column])) pivot = row;
        std::swap(m[pivot], m[column]);
        std::swap(result[pivot], result[column]);
        const double scale = 1.0 / m[column][column];
        for (std::size_t k = 0; k < n; ++k) {
            m[column][k] *= scale;
            result[column][k] *= scale;
        }
        for (std::size_t row = 0; row < n; ++row) {
            if (row == column) continue;
            const double factor = m[row][column];
            for (std::size_t k = 0; k < n; ++k) {
                m[row][k] -= factor * m[column][k];
                result[row][k] -= factor * result[column][k];
            }
        }
    }
    return result;
}
}  // namespace

MomentQuantiser::MomentQuantiser(int order) {
    CHECK(order >= 2 && order <= kMaxMomentOrder, "order {}", order);
    const Map& map = order == 2 ? kFour : order == 3 ? kSix : kEight;
    const auto n = static_cast<std::size_t>(order);
    const DoubleMatrix odd = inverse(map.odd, n);
    const DoubleMatrix even = inverse(map.even, n);
    for (std::size_t i = 0; i < n; ++i) {
        offset_[2 * i] = 0.5f;
        offset_[2 * i + 1] = static_cast<float>(map.even_offset[i]);
        for (std::size_t j = 0; j < n; ++j) {
            forward_[0][i][j] = static_cast<float>(map.odd[i][j]);
            forward_[1][i][j] = static_cast<float>(map.even[i][j]);
            inverse_[0][i][j] = static_cast<float>(odd[i][j]);
            inverse_[1][i][j] = static_cast<float>(even[i][j]);
        }
    }
}

}  // namespace ropsim
