// Stochastic transparency: Enderton, Sintorn, Shirley and Luebke 2011, all its methods (rop/sampling). How a
// fragment picks its samples: an independent coin a sample, or R = floor(alpha n + xi) of the n it covers as
// a uniformly random subset (3.1), a run, or an entry of a precomputed table (5); fixed alpha to coverage as
// hardware does it (2), and spatiotemporal blue noise (Wolfe et al. 2022). Left open by the paper and
// switchable here: whether occluded samples leave before R is chosen (depth_test=first, as Laine and Karras
// 2011, section 5, compare with). Section 6's seeds, and fewer samples over bright backgrounds.
// seed_from=pattern is the index of Salvi et al. 2011, section 4, whose x^2 + y is taken literally.
#include "rop/sampling/mask_chooser.h"
#include "rop/sampling/stored_samples.h"

namespace ropsim {

class Stochastic : public StoredSamples<MaskChooser> {
 public:
    static constexpr TechniqueInfo kInfo = {
        "stochastic", "stochastic transparency (Enderton et al. 2011)",
        "masks=choose|coin|run|table|alpha_to_coverage|blue_noise, rounding=random|dither, "
        "depth_test=last|first, seed_from=primitive|depth|object|object_facing|pattern, "
        "bright_samples=samples, dark_below=0.25, samples=8 (1..64, a multiple of the trace's), "
        "method=basic|depth_based, correction=none|coverage|accumulated, total_alpha=pixel|sample, "
        "accumulator=pixel|sample, passes=separate|merged, hardware_samples=0 (of one round; 0: all), "
        "strata=all|pass, filter=box|gaussian, early_termination=false, adaptive_error=0, adaptive_rounds=4, "
        "cross_filter=0, "
        "cross_sigma=0.05",
        true, "samples=8"};
    using StoredSamples::StoredSamples;

    std::uint32_t pixel_constant(int, int, glm::vec3 background) const {
        return chooser().pixel_constant(background);
    }
    std::uint64_t random_key(const Fragment& f) const { return chooser().random_key(f); }
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(stochastic, Stochastic)
