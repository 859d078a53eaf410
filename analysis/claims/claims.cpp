// Chooses claims, hears what they need, runs it, judges.
#include "analysis/claims/claims.h"

#include "base/edit_distance.h"
#include "base/error.h"
#include "base/parallel.h"

#include <algorithm>

#include <fmt/ranges.h>

namespace ropsim {
namespace {

// The ids that are spelt most like it, or contain it.
std::string ids_near(const std::vector<Claim>& claims, const std::string& id) {
    constexpr std::size_t kMost = 5;
    std::vector<std::pair<std::size_t, std::string>> ranked;
    for (const Claim& claim : claims) {
        // Someone may not have got to the end of the id.
        const std::size_t begun = edit_distance(id, claim.id.substr(0, id.size()));
        const bool part = claim.id.find(id) != std::string::npos;
        ranked.emplace_back(part ? 0 : std::min(begun, edit_distance(id, claim.id)), claim.id);
    }
    std::ranges::sort(ranked);
    std::vector<std::string> ids;
    for (const auto& [distance, name] : ranked)
        if (ids.size() < kMost) ids.push_back(name);
    return fmt::format("{}", fmt::join(ids, ", "));
}

bool matches(const std::string& id, const std::string& given) {
    if (!given.ends_with('*')) return id == given;
    return id.starts_with(given.substr(0, given.size() - 1));
}

ClaimResult result_of(const Claim& claim, ClaimRuns& runs) {
    ClaimResult result{&claim, {}, {}, ""};
    try {
        result.finding = claim.measure(runs);
    } catch (const UserError& error) {  // of a trace that is not there: the reason is among the failures
        result.failure = fmt::format("{}: {}", error.where(), error.what());
    }
    if (claim.simulates)  // the others run side by side
        if (const std::string failures = runs.take_failures(); !failures.empty()) result.failure = failures;
    if (result.failure.empty())
        result.judgement = judge(claim.printed, claim.rule, claim.basis, result.finding);
    return result;
}

}  // namespace

std::vector<const Claim*> chosen_claims(const std::vector<Claim>& claims,
                                        const std::vector<std::string>& ids) {
    for (const std::string& id : ids)
        if (std::ranges::none_of(claims, [&](const Claim& claim) { return matches(claim.id, id); }))
            throw UserError("ID", fmt::format("there is no claim '{}'; near it are {}; `ropsim list claims` "
                                              "names them all",
                                              id, ids_near(claims, id)));
    std::vector<const Claim*> chosen;
    for (const Claim& claim : claims)
        if (ids.empty() ||
            std::ranges::any_of(ids, [&](const std::string& id) { return matches(claim.id, id); }))
            chosen.push_back(&claim);
    return chosen;
}

std::vector<ClaimResult> run_claims(const ClaimsOptions& options) {
    const std::vector<const Claim*> claims = chosen_claims(all_claims(), options.ids);
    ClaimRuns runs(options.runs);
    for (const Claim* claim : claims)
        if (claim->simulates) claim->measure(runs);
    runs.execute();
    // Those that enumerate take their time; those of runs only look up.
    std::vector<ClaimResult> results(claims.size());
    parallel_for(default_threads(), static_cast<int>(claims.size()), [&](int i) {
        const auto at = static_cast<std::size_t>(i);
        if (!claims[at]->simulates) results[at] = result_of(*claims[at], runs);
    });
    for (std::size_t i = 0; i < claims.size(); ++i)
        if (claims[i]->simulates) results[i] = result_of(*claims[i], runs);
    return results;
}

}  // namespace ropsim
