// Claims of McGuire and Mara 2017 about the arithmetic of Listing 1, counted line by line.
#include "analysis/claims/declared_cost.h"
#include "analysis/claims/phenomenological.h"

#include <span>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Listing 1 line by line: operations on scalars, a clamp being two; what its calls do inside is not in it.
struct ListedLine {
    const char* line;
    int operations;
};
constexpr ListedLine kWeighting[] = {{"netCoverage = alpha * (1.0 - dot(t, vec3(1.0/3.0)))", 1 + 1 + 5},
                                     {"tmp = (1.0 - gl_FragCoord.z * 0.99) * netCoverage * 10.0", 4},
                                     {"w = clamp(tmp * tmp * tmp, 0.01, 30.0)", 2 + 2},
                                     {"A = vec4(L_r * alpha, netCoverage) * w", 3 + 4}};
constexpr ListedLine kRefraction[] = {{"delta = refractPix * netCoverage * (1.0 / 63.0)", 2 + 2}};

int operations(std::span<const ListedLine> lines) {
    int sum = 0;
    for (const ListedLine& line : lines) sum += line.operations;
    return sum;
}

}  // namespace

void add_phenomenological_operation_claims(std::vector<Claim>& claims) {
    claims.push_back(
        {"mm-25-operations", kPhenomenologicalPaper, "section 7.3, listing 1",
         "Weighting and refraction in Listing 1 add about 25 arithmetic operations to a fragment",
         Printed::numbers_of("25"), rule::about(), Basis::kDefinition,
         "scalar operations of Listing 1's lines, and those that the technique charges for equations 8 to 10",
         false, [](ClaimRuns&) {
             const auto alu = [](const char* technique) {
                 return declared_cost(technique, 1, true).declaration.added_shading.alu_instructions;
             };
             const int refraction = alu("phenomenological") - alu("phenomenological:refraction=off");
             const int weighting = operations(kWeighting);
             const int listed = weighting + operations(kRefraction);
             const double all = weighting + refraction;
             ClaimTable table{{"Listing 1", "operations"}, {}};
             for (const auto& lines :
                  {std::span<const ListedLine>(kWeighting), std::span<const ListedLine>(kRefraction)})
                 for (const ListedLine& line : lines)
                     table.rows.push_back({line.line, std::to_string(line.operations)});
             return Finding{
                 {all},
                 {},
                 {{"", {all}},
                  {"the lines that Listing 1 prints, what its call of refractOffset does not counted",
                   {static_cast<double>(listed)}}},
                 fmt::format("{} of weighting and {} of refraction; {} in the listing's own lines, which "
                             "do not have refractOffset's",
                             weighting, refraction, listed),
                 table};
         }});
}

}  // namespace ropsim
