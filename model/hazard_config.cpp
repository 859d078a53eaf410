#include "model/hazard_config.h"

namespace ropsim {

HazardConfig read_hazards(Parameters& p) {
    HazardConfig c;
    const std::string interlock = p.get_choice("rop.interlock", "quad", {"pixel", "quad", "tile"});
    c.interlock = interlock == "pixel"  ? HazardConfig::Interlock::kPixel
                  : interlock == "quad" ? HazardConfig::Interlock::kQuad
                                        : HazardConfig::Interlock::kTile;
    c.forward_results = p.get_choice("rop.forwarding", "none", {"none", "result"}) == "result";
    c.write_coalescing = static_cast<std::uint32_t>(p.get_integer("rop.write_coalescing", 0, 0, 64));
    return c;
}

}  // namespace ropsim
