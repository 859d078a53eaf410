// Claims of Laine and Karras 2011, "Stratified Sampling for Stochastic Transparency".
#include "analysis/claims_list.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Laine and Karras 2011";

struct Table1Row {
    int samples;
    double ours, comparison;
    const char* ratio;
};

// Ratios of the printed errors; ours are of this project's scene of the kind.
void add_table1(std::vector<Claim>& claims, const std::string& scene, const std::vector<Table1Row>& rows) {
    for (const Table1Row& row : rows) {
        const int samples = row.samples;
        claims.push_back(
            {fmt::format("lk-table1-{}-{}", scene, samples), kPaper, "Table 1",
             fmt::format("RMSE over the comparison method's, {} samples, {}", samples, scene),
             Printed::numbers_of(row.ratio), rule::digits(), Basis::kAssets,
             "RMSE of two runs on this project's scene of that name", true,
             [scene, samples](ClaimRuns& runs) {
                 const ClaimTrace trace{scene, "500x500", "128x128"};
                 const double ours =
                     number_of(runs.run({trace, fmt::format("laine_karras:samples={}", samples)}).rmse8);
                 const double theirs = number_of(
                     runs.run({trace, fmt::format("stochastic:samples={},depth_test=first", samples)}).rmse8);
                 return Finding{
                     {},
                     {ours / theirs},
                     {{fmt::format("our scene {}", scene), {ours / theirs}}},
                     fmt::format("{:.2f} over {:.2f} here; the model is not public", ours, theirs)};
             }});
    }
}

}  // namespace

void add_laine_karras_claims(std::vector<Claim>& claims) {
    add_table1(claims, "motor",
               {{4, 29.5, 36.3, "0.81"},
                {8, 17.9, 25.3, "0.71"},
                {16, 10.3, 17.2, "0.60"},
                {32, 6.3, 12.1, "0.52"},
                {64, 4.0, 8.7, "0.46"}});
    add_table1(claims, "cloth",
               {{4, 17.0, 19.3, "0.88"},
                {8, 9.7, 12.3, "0.79"},
                {16, 5.6, 8.4, "0.67"},
                {32, 3.3, 5.8, "0.57"},
                {64, 2.0, 4.1, "0.49"}});
}

}  // namespace ropsim
