// Keys of the front end: names, defaults and ranges.
#include "model/front_end_config.h"

#include "base/error.h"

namespace ropsim {

namespace {

std::uint32_t count(Parameters& p, const std::string& key, std::uint32_t fallback, std::int64_t low,
                    std::int64_t high) {
    return static_cast<std::uint32_t>(p.get_integer(key, fallback, low, high));
}

}  // namespace

FrontEndConfig read_front_end(Parameters& p) {
    FrontEndConfig c;
    HierarchicalDepthConfig& hierarchical = c.hierarchical;
    hierarchical.enabled = p.get_flag("hiz.enabled", hierarchical.enabled);
    hierarchical.accepts = p.get_flag("hiz.accepts", hierarchical.accepts);
    hierarchical.bits = count(p, "hiz.bits", hierarchical.bits, 4, 32);
    hierarchical.kibibytes = count(p, "hiz.kibibytes", hierarchical.kibibytes, 0, 65536);
    return c;
}

}  // namespace ropsim
