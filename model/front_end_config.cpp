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
    ShaderCoreConfig& shader = c.shader;
    shader.cores = count(p, "shader.cores", shader.cores, 1, 1024);
    shader.warp_quads = count(p, "shader.warp_quads", shader.warp_quads, 1, 64);
    shader.warps = count(p, "shader.warps", shader.warps, 1, 1024);
    shader.pack_timeout = count(p, "shader.pack_timeout", shader.pack_timeout, 0, 1 << 20);
    c.raster_tiles_per_cycle = count(p, "shader.raster_tiles_per_cycle", c.raster_tiles_per_cycle, 1, 1024);
    return c;
}

}  // namespace ropsim
