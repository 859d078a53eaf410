// A validation as a section of a page, which tests/validation/scenes puts together.
#include "analysis/comparison_table.h"
#include "analysis/validation.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

std::string count_text(std::uint64_t count) {
    return format_measured(static_cast<double>(count), 0, ",", "");
}

std::string percent(double share) {
    // Rounded down: 100 means all.
    return fmt::format("{:g}", std::floor(1e6 * share) / 1e4);
}

std::string worst_text(const Agreement& a) {
    if (a.worst_units == 0) return "0";
    return fmt::format("{:.2g} {}", a.worst_units, unit_name(a.stored));
}

}  // namespace

std::string validation_markdown(const Validation& v) {
    const auto compared =
        std::ranges::count_if(v.techniques, [](const ValidatedTechnique& t) { return t.failure.empty(); });
    const auto differ =
        std::ranges::count_if(v.techniques, [](const ValidatedTechnique& t) { return t.differs(); });
    std::string text = fmt::format(
        "## {}\n\n{}x{} pixels, {} fragments, {} spatial samples, drawn as {} by `{}`. Of {} covered pixels "
        "{} "
        "have other fragments in the trace than OpenGL draws. Of {} comparisons {} are within their "
        "bounds.\n\n"
        "| technique | stored | worst | equal, % | within, % | verdict | cause "
        "|\n|---|---|--:|--:|--:|---|---|\n",
        v.options.input.substr(v.options.input.rfind('/') + 1), v.width, v.height, count_text(v.fragments),
        v.samples, v.drawn, v.renderer, count_text(v.covered), count_text(v.other_fragments), compared,
        compared - differ);
    std::string refused;
    for (const ValidatedTechnique& t : v.techniques) {
        if (!t.failure.empty()) {
            refused += fmt::format("\n- `{}`: {}", t.technique, t.failure);
            continue;
        }
        const Agreement& a = t.agreement;
        text +=
            fmt::format("| `{}` | {} | {} | {} | {} | {} | {} |\n", t.technique, format_info(a.stored).name,
                        worst_text(a), percent(a.equal_share()), percent(a.within_share()),
                        t.differs() ? "**differs**" : "agrees", t.cause().empty() ? "-" : t.cause());
    }
    return refused.empty() ? text : text + "\nRefused:\n" + refused + "\n";
}

}  // namespace ropsim
