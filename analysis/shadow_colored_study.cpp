#include "analysis/shadow_colored_study.h"

namespace ropsim {

ColoredStudy study_colored_shadows(TraceReader& light, TraceReader& camera, const ShadowMapRun& run,
                                   const FilterChoice& filter, const ShadowReceiving& receiving,
                                   const std::string& shadowed, const std::string& exact) {
    ColoredStudy study;
    const ColoredReference reference(light, run.colored, run.colored.empty_is_opaque && !filter.variance,
                                     receiving.threads);
    ColoredShadow shadow{run, reference, filter, {}, {}};
    for (std::size_t w = 0; filter.variance && w < run.wavelengths.size(); ++w) {
        const VarianceOptions& options = filter.conversion;
        const MomentImage moments = stored_moments(run.wavelengths[w]);
        const ExpectedMoments expected =
            expected_moments(reference, w, run.colored.empty_is_opaque, receiving.threads);
        shadow.variance.emplace_back(converted(moments, options, receiving.threads), options);
        shadow.expected.emplace_back(converted(expected.moments, options, receiving.threads), options);
        study.noise.push_back(map_noise(moments, expected, run.colored.samples, options, receiving.threads));
        study.reduced_width = shadow.variance[w].image().width;
        study.reduced_height = shadow.variance[w].image().height;
    }
    study.shadowed = cast_colored_shadows(camera, light.header(), shadow, receiving, shadowed, exact);
    return study;
}

}  // namespace ropsim
