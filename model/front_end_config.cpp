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
    DepthTestConfig& depth = c.depth;
    depth.early = p.get_choice("depth.test", "early", {"early", "late"}) == "early";
    depth.kibibytes = count(p, "depth.kibibytes", depth.kibibytes, 1, 65536);
    depth.ways = count(p, "depth.ways", depth.ways, 1, 64);
    depth.quads = count(p, "depth.quads", depth.quads, 1, 4096);
    depth.mshrs = count(p, "depth.mshrs", depth.mshrs, 1, 256);
    depth.latency = count(p, "depth.latency", depth.latency, 1, 1000);
    TextureConfig& texture = c.texture;
    texture.kibibytes = count(p, "texture.kibibytes", texture.kibibytes, 1, 1 << 20);
    texture.mebibytes = count(p, "texture.mebibytes", texture.mebibytes, 1, 4096);
    texture.l1_kibibytes = count(p, "texture.l1_kibibytes", texture.l1_kibibytes, 1, 1024);
    texture.l1_ways = count(p, "texture.l1_ways", texture.l1_ways, 1, 64);
    texture.latency = count(p, "texture.latency", texture.latency, 1, 10000);
    texture.mshrs = count(p, "texture.mshrs", texture.mshrs, 1, 1024);
    texture.quads_per_cycle = count(p, "texture.quads_per_cycle", texture.quads_per_cycle, 1, 64);
    ShaderCoreConfig& shader = c.shader;
    shader.cores = count(p, "shader.cores", shader.cores, 1, 1024);
    shader.warp_quads = count(p, "shader.warp_quads", shader.warp_quads, 1, 64);
    shader.warps = count(p, "shader.warps", shader.warps, 1, 1024);
    shader.pack_timeout = count(p, "shader.pack_timeout", shader.pack_timeout, 0, 1 << 20);
    c.raster_tiles_per_cycle = count(p, "shader.raster_tiles_per_cycle", c.raster_tiles_per_cycle, 1, 1024);
    return c;
}

void check_front_end(const Parameters& p, const FrontEndConfig& config, RopCacheConfig rop_cache) {
    const auto check = [&](const char* key, std::uint32_t kibibytes, std::uint32_t ways) {
        rop_cache.size_bytes = kibibytes * 1024;
        rop_cache.ways = ways;
        rop_cache.section_bytes = {};
        try {
            check_cache_config(rop_cache);
        } catch (const UserError& error) {
            throw UserError(p.where(key), error.what());
        }
    };
    if (config.depth.early) check("depth.kibibytes", config.depth.kibibytes, config.depth.ways);
    check("texture.l1_kibibytes", config.texture.l1_kibibytes, config.texture.l1_ways);
}

}  // namespace ropsim
