// The built-in scenes, one entry each, with what their papers print about them.
#include "capture/scene_list.h"

namespace ropsim {
namespace {

constexpr const char* kAt = "Adaptive transparency (2011)";
constexpr const char* kSt = "Stochastic transparency (2011)";

}  // namespace

const std::vector<SceneInfo>& scene_list() {
    static const std::vector<SceneInfo> scenes = {
        {.name = "horse",
         .summary = "translucent copies of glmark2's horse, at least 8 layers deep, on a checkered floor",
         .make = make_horse_scene},
        {.name = "bunny",
         .summary = "translucent copies of glmark2's bunny, at least 8 layers deep, on a checkered floor",
         .make = make_bunny_scene},
        {.name = "hair",
         .summary =
             "a head with long hair: thin translucent strands in order of growth, over 600 layers deep",
         .published = {.paper = kAt, .place = "Table 1", .fragments = 15.0e6, .deepest = 663},
         .make = make_hair_scene},
        {.name = "plume",
         .summary = "a plume of smoke from a chimney: 100,000 soft billboards of alpha .05, unsorted",
         .published = {.paper = kSt, .place = "Fig. 8", .primitives = 100'000, .primitive_name = "particles"},
         .make = make_plume_scene},
    };
    return scenes;
}

}  // namespace ropsim
