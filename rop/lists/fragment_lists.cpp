#include "rop/lists/fragment_lists.h"

#include "base/error.h"

#include <fmt/format.h>

namespace ropsim {

FragmentLists::FragmentLists(Declaration& declaration, const TechniqueFormats& formats, int spatial_samples) {
    if (spatial_samples > kMostSpatialSamples)
        throw UserError(
            "the trace",
            fmt::format("has {} spatial samples; lists keep a coverage mask of at most {} bits in "
                        "their depths: capture with fewer --samples",
                        spatial_samples, kMostSpatialSamples));
    mask_ = spatial_samples == 1 ? 0u : (1u << spatial_samples) - 1u;
    head_ = declaration.surface("head", 1, Layout::kInterleaved, Initial::kClear,
                                {FieldSpec::integer(32, kNoNode)})[0];
    const auto node = declaration.surface(
        "nodes", 1, Layout::kPool, Initial::kClear,
        {FieldSpec::real(formats.of("color", Format::kUnorm8), 4, 0.0f, ValueRange::kColor),
         FieldSpec::real(Format::kFloat32, 1, 0.0f, ValueRange::kUnit), FieldSpec::integer(32, kNoNode)});
    color_ = node[0];
    depth_ = node[1];
    next_ = node[2];
}

}  // namespace ropsim
