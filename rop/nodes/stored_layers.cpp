#include "rop/nodes/stored_layers.h"

#include <vector>

namespace ropsim {

StoredLayers::StoredLayers(Declaration& declaration, const TechniqueFormats& formats, int layers,
                           const LayerContents& contents)
    : contents_(contents), layers_(layers) {
    std::vector<FieldSpec> fields = {
        FieldSpec::real(formats.of("depth", Format::kFloat32), 1, kEmptyDepth, ValueRange::kUnit)};
    if (contents.color_channels > 0)
        fields.push_back(FieldSpec::real(formats.of("color", Format::kUnorm8), contents.color_channels, 0.0f,
                                         ValueRange::kColor));
    if (contents.alpha)
        fields.push_back(FieldSpec::real(formats.of("alpha", Format::kFloat32), 1, 0.0f, ValueRange::kUnit));
    if (contents.mask_bits > 0) fields.push_back(FieldSpec::integer(contents.mask_bits, 0));
    const auto handles = declaration.surface("layers", layers, Layout::kInterleaved, Initial::kClear, fields);
    std::size_t next = 0;
    depth_ = handles[next++];
    depths_ = NodeDepths(depth_.format);
    if (contents.color_channels > 0) color_ = handles[next++];
    if (contents.alpha) alpha_ = handles[next++];
    if (contents.mask_bits > 0) mask_ = handles[next++];
    if (contents.color_channels == 4) {
        alpha_ = color_;
        alpha_channel_ = 3;
    }
    for_words([&](const Field&, int) { ++words_; });
    color_words_ = (contents.color_channels * format_info(color_.format).bits + 31) / 32;
    muxes_ = (declaration.surfaces.back().element_bits + 31) / 32;
}

}  // namespace ropsim
