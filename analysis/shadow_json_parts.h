// What the two kinds of shadow.json share.
#pragma once

#include "analysis/shadow_study.h"

#include <nlohmann/json.hpp>

namespace ropsim {

nlohmann::ordered_json shadow_parameters_json(const Parameters& parameters);
nlohmann::ordered_json shadow_error_json(const VisibilityError& error);
// Null where nothing was measured.
nlohmann::ordered_json number_or_null(bool measured, double value);

// Sets `filter`, `fragments`, `opaque` and what else a coloured map's study has.
void add_colored_json(nlohmann::ordered_json& json, const ShadowStudy& study);

}  // namespace ropsim
