// The techniques the conformance tests run over: every one of technique_list(), so that a new one needs no
// line here.
#pragma once

#include "tests/rop/random_fragments.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim::test {

// Every technique with its defaults, in both formats, and corners of parameters worth the walk.
inline std::vector<std::string> technique_texts() {
    std::vector<std::string> texts;
    for (const TechniqueInfo& t : technique_list())
        for (const char* format : {"paper", "float32"})
            texts.push_back(std::string(t.name) + ":format=" + format);
    for (const char* corner :
         {"adaptive:nodes=2",
          "adaptive:nodes=5,depth_format=unorm24,transmittance_format=unorm8",
          "adaptive:nodes=64",
          "adaptive:nodes=4",
          "adaptive:nodes=16,memory=shader",
          "slab:layers=3,bits=inf",
          "slab:layers=1,bits=1",
          "slab:layers=64,bits=inf",
          "slab:layers=5,bits=256",
          "slab:layers=4,depth_format=float16",
          "stochastic:samples=12,depth_format=unorm24",
          "stochastic:samples=32,color_format=rgb9e5",
          "laine_karras:samples=12,color_format=r11g11b10",
          "laine_karras:samples=64",
          "stochastic:masks=coin,correction=coverage",
          "stochastic:masks=run,rounding=dither,samples=64",
          "stochastic:masks=table,method=depth_based,correction=none",
          "stochastic:masks=alpha_to_coverage,method=depth_based,correction=coverage",
          "stochastic:masks=blue_noise,method=depth_based,passes=merged",
          "stochastic:method=depth_based,total_alpha=sample,accumulator=sample",
          "stochastic:method=depth_based,total_alpha=sample,accumulator=sample,passes=merged",
          "stochastic:correction=coverage,passes=merged,early_termination=true",
          "stochastic:depth_test=first,early_termination=true",
          "stochastic:method=depth_based,early_termination=true,depth_format=unorm24",
          ("stochastic:method=depth_based,early_termination=true,passes=merged,total_alpha=pixel,accumulator="
           "pixel"),
          "stochastic:samples=12,hardware_samples=4,strata=pass",
          "stochastic:samples=12,hardware_samples=4,correction=coverage",
          "stochastic:samples=12,hardware_samples=4,method=depth_based,correction=coverage",
          "stochastic:samples=12,hardware_samples=4,method=depth_based",
          "stochastic:samples=32,hardware_samples=4,adaptive_error=20,adaptive_rounds=2",
          "stochastic:samples=32,hardware_samples=4,adaptive_error=20,adaptive_rounds=2,correction=coverage",
          "stochastic:samples=32,hardware_samples=4,adaptive_error=10,adaptive_rounds=2,method=depth_based",
          ("stochastic:samples=32,hardware_samples=4,adaptive_error=20,adaptive_rounds=2,method=depth_based,"
           "correction=coverage"),
          "stochastic:filter=gaussian",
          "stochastic:method=depth_based,cross_filter=2",
          "stochastic:filter=gaussian,correction=coverage,total_alpha=sample",
          "stochastic:filter=gaussian,method=depth_based,total_alpha=sample,accumulator=sample",
          "stochastic:samples=16,bright_samples=4",
          "stochastic:method=depth_based,bright_samples=4",
          "laine_karras:tracking=false,hash=improved",
          "laine_karras:compaction=false,hash=sobol",
          "laine_karras:sort=false,hash=radical_inverse,index=morton",
          "laine_karras:method=depth_based,samples=16",
          "laine_karras:correction=coverage,early_termination=true",
          "laine_karras:method=depth_based,samples=24,hardware_samples=8,strata=pass",
          "laine_karras:method=depth_based,samples=24,hardware_samples=8,total_alpha=pixel",
          "stochastic:seed_from=pattern,masks=table",
          "stochastic:seed_from=object_facing",
          "alpha_blend:color_format=rgb9e5",
          "weighted_blended:color_format=float32",
          "depth_peeling:ties=primitive",
          "depth_peeling:layers=3,depth_format=float16,layer_format=float16",
          "dual_depth_peeling:layers=5,color_format=float32",
          "dual_depth_peeling:depth_format=float16",
          "hashed_alpha:hash=primitive",
          "hashed_alpha:color_format=rgb9e5",
          "shadow_map:samples=4,masks=coin",
          "shadow_map:total_alpha=on,depth_format=unorm24",
          "colored_shadow_map:wavelengths=1,samples=4,draws=shared",
          "colored_shadow_map:draws=shared,samples=3,empty=far,caustics=off",
          "colored_shadow_map:caustics_sign=prose,caustics_index=interface,depth_green_format=unorm24",
          "colored_shadow_map:samples=64,seed_from=object",
          "mlab:layers=1",
          "mlab:layers=64,merge=least_error",
          "mlab:layers=3,merge=closest,ties=oldest",
          "mlab:layers=4,merge=least_error,depth_format=unorm24,color_format=rgb9e5",
          "mlab:layers=5,merge=transmittance,format=float32",
          "mlab:layers=4,merge=opacity,ties=oldest,depth_format=float16",
          "aoit:nodes=2",
          "aoit:nodes=3,transmittance_rounding=nearest,color_format=float16",
          "aoit:nodes=16,transmittance_format=unorm16,depth_format=unorm24",
          "z3:fragments=2,slope_bits=16",
          "z3:fragments=8,depth_format=unorm24,slope_bits=32",
          "weighted_blended:weight=blog2015,overflow=saturate",
          "weighted_blended:weight=learnopengl",
          "weighted_blended:weight=none,revealage_format=float16",
          "a_buffer:resolve=iterative",
          "a_buffer:overflow=blend_tail",
          "opacity_map:slices=1,lookup=step",
          "opacity_map:sums=slab,composite=normalised,slices_format=float16",
          "opacity_map:sums=slab,lookup=step,bounds=frame",
          "opacity_map:planes=deep,depth_range=0.3",
          "opacity_map:planes=deep,spacing=growing,sums=slab,slices=5",
          "opacity_map:memory=variable,composite=normalised",
          "opacity_map:memory=variable,planes=deep,lookup=step,slices=64",
          "opacity_map:bounds=frame,memory=variable",
          "fourier_map:coefficients=15,coefficients_format=float32",
          "fourier_map:bounds=frame",
          "fourier_map:coefficients=1,clamp=off",
          "fourier_map:guard=0.1,composite=normalised,coefficients=31",
          "fourier_map:memory=variable,coefficients=3",
          "occupancy_map:bits=32,composite=plain",
          "occupancy_map:bits=96,counts=slab,alpha=geometric",
          "occupancy_map:bits=64,alpha=constant,bounds=frame",
          "adaptive:nodes=2,removal=overestimate,candidates=protect_furthest",
          "adaptive:nodes=9,removal=overestimate,equal_depth=behind,format=float32",
          "adaptive:nodes=8,removal=node_by_node,candidates=protect_front_half,composite=normalised",
          "adaptive:nodes=7,removal=node_by_node,equal_depth=merge,depth_format=unorm16",
          "adaptive:nodes=8,candidates=protect_front_half,memory=shader,layout=planar",
          "adaptive:nodes=4,transmittance_format=unorm8,transmittance_rounding=down,depth_format=float16",
          "adaptive:nodes=4,transmittance_format=log8,transmittance_rounding=dithered,equal_depth=merge",
          ("adaptive:nodes=5,transmittance_format=float16,transmittance_rounding=dithered,composite="
           "normalised"),
          "adaptive:memory=variable,nodes=2,removal=node_by_node",
          "adaptive:memory=variable,nodes=5,removal=overestimate,equal_depth=merge,composite=normalised",
          "adaptive:memory=variable,equal_depth=behind,candidates=protect_furthest",
          "moment_based:moments=6",
          "moment_based:moments=8",
          "moment_based:guard=published",
          "moment_based:moments=6,guard=published",
          "moment_based:moments=8,guard=published",
          "moment_based:moments=8,moment_format=unorm16",
          "moment_based:moments=6,moment_format=unorm16,optical_depth_format=float32",
          "moment_based:moments=4,moment_format=unorm16,guard=published",
          "moment_based:basis=trigonometric",
          "moment_based:basis=trigonometric,moments=6,moment_format=unorm16",
          "moment_based:basis=trigonometric,moments=8",
          "wavelet:rank=1",
          "wavelet:rank=5,coefficient_format=float32",
          "wavelet:rank=2,bounds=frame",
          "wavelet:bounds_format=unorm16",
          "slab:layers=4,bits=2,probability=non_stratified",
          "slab:coverage=discrete,layers=4,bits=8",
          "slab:coverage=discrete,layers=16,bits=64,probability=non_stratified",
          "slab:coverage=discrete,layers=3,bits=40,composite=accumulated",
          "slab:coverage=discrete,layers=8,bits=8,composite=normalised",
          "slab:layers=4,composite=accumulated",
          "slab:layers=4,bits=1024,composite=normalised",
          "slab:layers=5,bits=inf,composite=normalised,alpha_format=unorm8",
          "slab:layers=4,depth_format=unorm16",
          "phenomenological:form=alpha",
          "phenomenological:form=alpha,weight=g3d,self_modulation=off",
          "phenomenological:separate_alpha=off,diffusion_sum=deviation,decoding=listing",
          "phenomenological:offsets=split,separate_alpha=off,weight=eq10",
          "phenomenological:offsets=biased,overflow=saturate,refraction=printed",
          "phenomenological:filter=gaussian,gather=exact,max_radius=9",
          "phenomenological:filter=gaussian,early_out=beta,beta=third,diffusion_weight=net",
          "phenomenological:refraction=off,background=infinite,underflow=round",
          "phenomenological:diffusion=off,refraction_weight=alpha,weight=none",
          "phenomenological:low_resolution=2,low_draws=all",
          "phenomenological:low_resolution=4,low_draws=all,upsample=bilinear,form=alpha",
          "phenomenological:aggregate_draws=all,aggregate_layers=2",
          "phenomenological:aggregate_draws=all,low_resolution=2,format=float32",
          "k_buffer:layers=1",
          "k_buffer:layers=64",
          "k_buffer:layers=4,depth_format=unorm16,color_format=float16",
          "k_plus_buffer:layers=2",
          "k_plus_buffer:layers=64",
          "k_plus_buffer:layers=5,depth_format=unorm8,color_format=float16",
          "hybrid:layers=1,tail_factor=off",
          "hybrid:layers=2,tail_format=packed_wrapping",
          "hybrid:layers=64,tail_format=float16",
          "hybrid:layers=3,depth_format=float16,color_format=float32"})
        texts.push_back(corner);
    return texts;
}

inline std::vector<std::string> technique_names() {
    std::vector<std::string> names;
    for (const TechniqueInfo& t : technique_list()) names.emplace_back(t.name);
    return names;
}

// A case as the name of a test.
inline std::string test_name(const testing::TestParamInfo<std::string>& info) {
    std::string name = info.param;
    std::ranges::replace_if(
        name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
    return name;
}

}  // namespace ropsim::test
