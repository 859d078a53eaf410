#include "analysis/stress/stress_page.h"

#include "base/error.h"

#include <cstddef>

#include <fmt/format.h>

namespace ropsim {

std::string with_stress_blocks(const std::string& page, const std::string& where,
                               const std::vector<StressBlock>& blocks) {
    std::string text = page;
    bool any = false;
    for (const auto& [name, block] : blocks) {
        const std::string begin = fmt::format("<!-- stress {} -->\n", name);
        const std::string end = fmt::format("<!-- end {} -->", name);
        const std::size_t mark = text.find(begin);
        if (mark == std::string::npos) continue;
        const std::size_t first = mark + begin.size();
        const std::size_t last = text.find(end, first);
        if (last == std::string::npos)
            throw UserError(where, fmt::format("has no \"{}\" behind its mark; write one", end));
        text.replace(first, last - first, "\n" + block + "\n");
        any = true;
    }
    if (!any)
        throw UserError(where,
                        fmt::format("has no mark of a table; write \"<!-- stress {0} -->\" and, on the "
                                    "next line, \"<!-- end {0} -->\" where it shall stand",
                                    blocks.empty() ? "NAME" : blocks.front().first));
    return text;
}

void check_stress_page(const std::string& page, const std::string& where,
                       std::span<const std::string_view> names) {
    std::vector<StressBlock> blocks;
    for (const std::string_view name : names) blocks.emplace_back(name, "");
    with_stress_blocks(page, where, blocks);
}

}  // namespace ropsim
