// Hazards of operations, whatever they are stored in: of their arithmetic and of what they leave out.
#include "analysis/stress/stress_hazard_scenes.h"
#include "analysis/stress/stress_hazards.h"

namespace ropsim {

using namespace hazard_scenes;

std::vector<StressHazardCase> arithmetic_hazards() {
    return {
        {.id = "lone_fragment_vanishes",
         .what = "a lone fragment makes the moments' matrix singular and is lost",
         .with = "moment_based:guard=published",
         .cured = "moment_based",
         .scenes = random_scenes(500, 1),
         .least_lost = 10 * kStep,
         .most_left = kStep},
        {.id = "thin_pixel_is_skipped",
         .what = "absorbance below .001 is taken as an empty pixel",
         .with = "moment_based:guard=published,format=float32",
         .cured = "moment_based:format=float32",
         .scenes = {layers(1, 0.0009f, {64, 64, 64})},
         .least_lost = 10 * kStep,
         .most_left = kStep},
        {.id = "ringing_brightens",
         .what = "the Fourier series rings: transmittance above 1 in front of dense layers",
         .with = "fourier_map:clamp=off,format=float32",
         .cured = "fourier_map:clamp=on,format=float32",
         .scenes = {[] {
             // The series of the opaque layer is below 0 where the white one stands.
             PixelScene scene = before(0);
             add(scene, 0.0f, 1e-4f, kBlack);
             add(scene, 0.05f, 0.3f, kWhite);
             add(scene, 0.5f, 1.0f, kBlack);
             add(scene, 1.0f, 1e-4f, kBlack);
             return scene;
         }()},
         .least_lost = 10 * kStep,
         .most_left = kStep},
        {.id = "light_is_scaled",
         .what = "light without alpha is scaled with the sum to the total alpha",
         .with = "opacity_map:composite=normalised,format=float32",
         .cured = "opacity_map:composite=plain,format=float32",
         .scenes = {[] {
             PixelScene scene = before(0);
             // The opaque layer stands between two planes, and dims itself.
             add(scene, 0.1f, 1e-6f, kBlack);
             add(scene, 0.53f, 1.0f, kBlack);
             add(scene, 0.9f, 1e-6f, kBlack);
             add(scene, 0.11f, 0.0f, kBlack);
             scene.fragments.back().r = scene.fragments.back().g = scene.fragments.back().b = 0.1f;
             return scene;
         }()},
         .least_lost = 0.5,
         .most_left = kStep},
    };
}

std::vector<StressHazardCase> approximation_hazards() {
    return {
        {.id = "coplanar_layers_add",
         .what = "fragments of one depth do not hide one another: two of alpha .5 show 1 for .75",
         .with = "adaptive:nodes=8,format=float32",
         .cured = "adaptive:nodes=8,format=float32,equal_depth=merge",
         .scenes = {two(0.5f, 0.5f, kWhite, 0.5f, 0.5f, kWhite)},
         .least_lost = 0.2,
         .most_left = kStep},
        {.id = "underestimation_darkens",
         .what = "underestimated visibility adds up to less than alpha: 200 white layers of .01",
         .with = "adaptive:nodes=8,format=float32",
         .cured = "adaptive:nodes=8,format=float32,composite=normalised",
         .scenes = {layers(200, 0.01f, kWhite)},
         .least_lost = 20 * kStep,
         .most_left = kStep},
        {.id = "tail_without_its_alpha",
         .what = "the tail's mean colour without its alpha is added in full",
         .with = "hybrid:layers=2,format=float32,tail_factor=off",
         .cured = "hybrid:layers=2,format=float32",
         .scenes = random_scenes(500, 3),
         .least_lost = 15 * kStep,
         .most_left = kStep},
        {.id = "overflow_is_dropped",
         .what = "what falls out of a k-buffer is lost",
         .with = "k_buffer:layers=4,format=float32",
         .cured = "k_buffer:layers=16,format=float32",
         .scenes = {layers(12, 0.2f)},
         .least_lost = 0.2,
         .most_left = kStep},
        {.id = "merged_layer_is_too_near",
         .what = "a merged layer keeps the nearer depth: a fragment between comes to lie behind",
         .with = "mlab:layers=2,format=float32",
         .cured = "mlab:layers=4,format=float32",
         .scenes = {[] {
             PixelScene scene = before(0);
             add(scene, 0.1f, 0.1f, kBlack);
             add(scene, 0.2f, 0.5f, kBlack);
             add(scene, 0.8f, 0.9f, kBlack);
             add(scene, 0.5f, 0.8f, kWhite);
             return scene;
         }()},
         .least_lost = 0.2,
         .most_left = kStep},
        {.id = "thin_alpha_is_never_inserted",
         .what = "alpha below 1/2b rounds to no bit and is never inserted",
         .with = "slab:layers=8,bits=16,format=float32",
         .cured = "slab:layers=8,bits=1024,format=float32",
         .scenes = {layers(8, 0.03f)},
         .seeds = 256,
         .least_lost = 0.2,
         .most_left = 2 * kStep},
        {.id = "coplanar_layers_collapse",
         .what = "peeling keeps one layer of each depth",
         .with = "depth_peeling:ties=collapse,format=float32",
         .cured = "depth_peeling:ties=primitive,format=float32",
         .scenes = {two(0.5f, 0.5f, kWhite, 0.5f, 0.5f, kWhite)},
         .least_lost = 0.2,
         .most_left = kStep},
        {.id = "masks_correlate",
         .what = "fixed masks of alpha to coverage: equal layers hide one another",
         .with = "stochastic:samples=8,masks=alpha_to_coverage,format=float32",
         .cured = "stochastic:samples=8,format=float32",
         .scenes = {layers(2, 0.5f)},
         .seeds = 4096,
         .least_lost = 0.2,
         .most_left = 4 * kStep},
        {.id = "same_seed_occludes",
         .what = "fragments of one seed have one mask: they hide one another",
         .with = "stochastic:samples=8,seed_from=object,format=float32",
         .cured = "stochastic:samples=8,format=float32",
         .scenes = {layers(2, 0.5f)},
         .seeds = 4096,
         .least_lost = 0.2,
         .most_left = 4 * kStep},
        {.id = "radical_inverse_is_biased",
         .what = "plain radical inverses correlate from surface to surface",
         .with = "laine_karras:samples=8,hash=radical_inverse,format=float32",
         .cured = "laine_karras:samples=8,format=float32",
         .scenes = {layers(8, 0.1f)},
         .seeds = 4096,
         .least_lost = 0.2,
         .most_left = 4 * kStep},
        {.id = "few_samples_are_empty",
         .what = "pixels of alpha below 1/S are empty or too full; two passes more find their alpha",
         .with = "stochastic:samples=4,format=float32",
         .cured = "stochastic:samples=4,method=depth_based,correction=accumulated,format=float32",
         .scenes = pixels_of_one_layer(64, 0.1f),
         .least_lost = 20 * kStep,
         .most_left = kStep},
    };
}

}  // namespace ropsim
