#include "rop/registry.h"

#include "base/error.h"

#include <algorithm>

#include <fmt/ranges.h>

namespace ropsim {

namespace techniques {
#define TECHNIQUE(name)          \
    TechniqueInfo name##_info(); \
    std::unique_ptr<FramebufferOperation> make_##name(Parameters&, const Screen&);
#include "rop/techniques/registry.def"
#undef TECHNIQUE
}  // namespace techniques

namespace {

using Maker = std::unique_ptr<FramebufferOperation> (*)(Parameters&, const Screen&);

constexpr Maker kMakers[] = {
#define TECHNIQUE(name) techniques::make_##name,
#include "rop/techniques/registry.def"
#undef TECHNIQUE
};

}  // namespace

const std::vector<TechniqueInfo>& technique_list() {
    static const std::vector<TechniqueInfo> list = {
#define TECHNIQUE(name) techniques::name##_info(),
#include "rop/techniques/registry.def"
#undef TECHNIQUE
    };
    return list;
}

TechniqueSpec parse_technique(const std::string& text, const std::string& where) {
    const std::size_t colon = text.find(':');
    const std::string name = text.substr(0, colon);
    const auto& list = technique_list();
    if (std::none_of(list.begin(), list.end(), [&](const TechniqueInfo& t) { return t.name == name; })) {
        std::vector<std::string_view> names;
        for (const TechniqueInfo& t : list) names.push_back(t.name);
        throw UserError(
            where, fmt::format("unknown technique '{}'; choose one of {}", name, fmt::join(names, ", ")));
    }
    const std::string parameters = colon == std::string::npos ? "" : text.substr(colon + 1);
    return {name, Parameters::from_list(fmt::format("technique '{}'", name), parameters, where)};
}

std::unique_ptr<FramebufferOperation> make_operation(TechniqueSpec& spec, const Screen& screen) {
    const auto& list = technique_list();
    for (std::size_t i = 0; i < list.size(); ++i) {
        if (list[i].name != spec.name) continue;
        auto operation = kMakers[i](spec.parameters, screen);
        spec.parameters.close();
        if (screen.samples > 1 && !operation->declaration().uses_coverage)
            throw UserError(
                fmt::format("technique '{}'", spec.name),
                fmt::format("works on traces of one sample a pixel, this one has {}; capture it with "
                            "--samples 1, or use one that takes several, as adaptive or stochastic do",
                            screen.samples));
        return operation;
    }
    CHECK(false, "technique '{}' was not parsed", spec.name);
}

}  // namespace ropsim
