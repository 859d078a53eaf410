#include "rop/phenomenological/framebuffer_targets.h"

namespace ropsim {

namespace {

// The step of a fixed-point format above 0; floating point has no need to be helped.
float smallest_code(Format format) {
    switch (format) {
        case Format::kUnorm8:
            return 1.0f / 255;
        case Format::kSnorm8:
            return 1.0f / 127;
        case Format::kUnorm16:
            return 1.0f / 65535;
        case Format::kUnorm24:
            return 1.0f / 16777215;
        default:
            return 0;
    }
}

}  // namespace

FramebufferTargets::FramebufferTargets(Declaration& declaration, const TargetFormats& formats,
                                       const PhenomenologicalOptions& options, const std::string& prefix,
                                       int scale)
    : saturates_(options.saturates), has_diffusion_(!options.alpha_only), offsets_(options.offsets) {
    using Fields = std::vector<FieldSpec>;
    const auto declare = [&](const char* name, const Fields& fields) {
        return declaration.surface(prefix + name, 1, Layout::kInterleaved, Initial::kClear, fields, scale);
    };
    accumulated_ =
        declare("accumulated", {FieldSpec::real(formats.accumulated, 4, 0.0f, ValueRange::kSum)})[0];
    // A UNORM target of offsets is as wide as the signed one it stands in for.
    const Format unsigned_delta = formats.delta == Format::kSnorm8 ? Format::kUnorm8 : formats.delta;
    const Format delta = offsets_ == Offsets::kSigned ? formats.delta : unsigned_delta;
    const float clear = offsets_ == Offsets::kBiased ? 0.5f : 0.0f;
    bias_ = stored_value(delta, clear);
    // Without materials, or where they are left out, nothing is ever added to either sum.
    const ValueRange offset_range = !options.refracts              ? ValueRange::kUnit
                                    : offsets_ == Offsets::kSigned ? ValueRange::kSignedSum
                                                                   : ValueRange::kSum;
    const ValueRange diffusion_range = options.diffuses ? ValueRange::kSum : ValueRange::kUnit;
    Fields rest = {FieldSpec::real(delta, offsets_ == Offsets::kSplit ? 4 : 2, clear, offset_range)};
    if (!has_diffusion_) {
        beta_ = declare("beta", {FieldSpec::real(formats.beta, 1, 1.0f, ValueRange::kUnit)})[0];
        offset_ = declare("delta", rest)[0];
        return;
    }
    if (options.separate_alpha) {
        const auto fields = declare("beta", {FieldSpec::real(formats.beta, 3, 1.0f, ValueRange::kUnit),
                                             FieldSpec::real(formats.beta, 1, 0.0f, diffusion_range)});
        beta_ = fields[0];
        diffusion_ = fields[1];
        offset_ = declare("delta", rest)[0];
    } else {
        // Three channels are aligned to four: the last holds nothing.
        beta_ = declare("beta", {FieldSpec::real(formats.beta, 3, 1.0f, ValueRange::kUnit),
                                 FieldSpec::real(formats.beta, 1, 0.0f, ValueRange::kUnit)})[0];
        rest.push_back(FieldSpec::real(delta, 1, 0.0f, diffusion_range));
        if (offsets_ != Offsets::kSplit) rest.push_back(FieldSpec::real(delta, 1, 0.0f, ValueRange::kUnit));
        const auto fields = declare("delta", rest);
        offset_ = fields[0];
        diffusion_ = fields[1];
    }
    least_diffusion_ = smallest_code(diffusion_.format);
}

}  // namespace ropsim
