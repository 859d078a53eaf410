// The built-in scenes, one entry each, with what their papers print about them.
#include "capture/scene_list.h"

namespace ropsim {
namespace {

constexpr const char* kAt = "Adaptive transparency (2011)";
constexpr const char* kPhenomenological = "Phenomenological transparency (2017)";
constexpr const char* kLk = "Stratified sampling for stochastic transparency (2011)";
constexpr const char* kSt = "Stochastic transparency (2011)";
constexpr const char* kGs = "Kerbl et al. 2023, 3D Gaussian splatting";

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
        {.name = "dog",
         .summary = "a dog with 300,000 hairs: short fur, coat and feathering over an opaque body",
         .published = {.paper = kSt, .place = "Fig. 7", .primitives = 300'000, .primitive_name = "hairs"},
         .width = 500,
         .height = 500,
         .make = make_dog_scene},
        {.name = "windy_hill",
         .summary = "15,000 hairs, 6,000 cards of grass and leaves, and a sheer scarf in the wind",
         .published = {.paper = kSt, .place = "Fig. 1", .primitives = 15'000, .primitive_name = "hairs"},
         .width = 500,
         .height = 500,
         .make = make_windy_hill_scene},
        {.name = "plume",
         .summary = "a plume of smoke from a chimney: 100,000 soft billboards of alpha .05, unsorted",
         .published = {.paper = kSt, .place = "Fig. 8", .primitives = 100'000, .primitive_name = "particles"},
         .make = make_plume_scene},
        {.name = "smoke",
         .summary = "fires in a yard: smoke through a wire fence, windows, vehicles and leaves",
         .published = {.paper = kAt, .place = "Table 1", .fragments = 10.6e6, .deepest = 312},
         .make = make_smoke_scene},
        {.name = "forest",
         .summary = "a wood of trees, ferns and grass on cards with smooth cut-outs, in random order",
         .published = {.paper = kAt, .place = "Table 1", .fragments = 6.0e6, .deepest = 45},
         .make = make_forest_scene},
        {.name = "power_plant",
         .summary = "a CAD model of a power plant, every shell see-through",
         .published = {.paper = kAt,
                       .place = "Table 1",
                       .fragments = 2.69e6,
                       .deepest = 35,
                       .fragments_4x = 3.47e6,
                       .deepest_4x = 60},
         .make = make_power_plant_scene},
        {.name = "splats",
         .summary = "a garden as a trained capture of 1,000,000 3D Gaussian splats, unsorted",
         .published = {.paper = kGs, .place = "Sec. 4", .primitives = 1'000'000, .primitive_name = "splats"},
         .make = make_splats_scene},
        {.name = "glass",
         .summary = "a chess game of red and clear glass by a window, with crossed bars of coloured glass",
         .published = {.paper = kPhenomenological, .place = "Figs. 7, 18, 19"},
         .make = make_glass_scene},
        {.name = "fog",
         .summary =
             "a street at night: fog that thickens with depth, lamps with glass panes, a tree's leaves",
         .published = {.paper = kPhenomenological, .place = "Figs. 1, 13 to 16, 23"},
         .make = make_fog_scene},
        {.name = "bottles",
         .summary = "four coloured plastic bottles in front of one another on a table in a courtyard",
         .published = {.paper = kPhenomenological, .place = "Fig. 12"},
         .make = make_bottles_scene},
        {.name = "panes",
         .summary =
             "a row of glass panes from clear to frosted, with coloured ones, before things near and far",
         .published = {.paper = kPhenomenological, .place = "Figs. 1, 8"},
         .make = make_panes_scene},
        {.name = "engine",
         .summary = "a car engine as a CAD program shows it, every part translucent",
         .published = {.paper = kPhenomenological, .place = "Fig. 20"},
         .make = make_engine_scene},
        {.name = "motor",
         .summary = "a geared electric motor of 322,000 white triangles, alpha .3, in model order",
         .published = {.paper = kSt, .place = "Fig. 2", .primitives = 322'000, .primitive_name = "triangles"},
         .width = 500,
         .height = 500,
         .make = make_motor_scene},
        {.name = "cloth",
         .summary =
             "a colourful blanket over a rail, its pleats overlapping: alpha .4, triangles in random order",
         .published = {.paper = kLk, .place = "Fig. 10"},
         .width = 500,
         .height = 500,
         .make = make_cloth_scene},
    };
    return scenes;
}

}  // namespace ropsim
