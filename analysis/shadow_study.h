// A stochastic shadow map from end to end: the light's view drawn into a map, the camera's view looked up in
// it, and both held against the exact visibility.
#pragma once

#include "analysis/shadow_colored_study.h"
#include "analysis/shadow_map_run.h"
#include "analysis/shadowed_trace.h"

#include <optional>
#include <string>

namespace ropsim {

struct ShadowStudyOptions {
    ShadowMapOptions map;
    FilterChoice filter;
    ShadowReceiving receiving;  // its seed and threads are the map's, its filter is the choice's
    std::string camera_trace;
    std::string directory;
};

struct ShadowStudy {
    ShadowStudyOptions options;
    ShadowMapRun run;
    ShadowedTrace shadowed;               // of a plain map
    std::optional<ColoredStudy> colored;  // of a coloured one
    std::string camera_hash;
    double host_seconds = 0;  // without pictures
};

// Throws UserError unless the first trace is the view of the second one's light, as far as headers can tell.
void check_light_view(const TraceReader& light, const TraceReader& camera);

// Writes map.png, shadowed.trace, exact.trace and shadowed.png (composited exactly) into the directory,
// created if need be. A shadow.json from before is taken away first. Throws UserError: for traces that are
// not the light's and the camera's view of one scene, and everything that draw_shadow_map() and
// cast_shadows() refuse.
ShadowStudy study_shadows(const ShadowStudyOptions& options);

// The text of shadow.json. Same inputs, same text, `host` apart.
std::string shadow_json(const ShadowStudy& study);

}  // namespace ropsim
