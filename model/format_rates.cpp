#include "model/format_rates.h"

#include "model/surface_map.h"
#include "rop/operation_log.h"

namespace ropsim {

FormatRates read_format_rates(Parameters& parameters) {
    const auto read = [&](const char* key, std::uint32_t fallback) {
        return static_cast<std::uint32_t>(parameters.get_integer(key, fallback, 1, 64));
    };
    FormatRates rates;
    rates.bits_32 = read("rop.rate.bits_32", rates.bits_32);
    rates.bits_64 = read("rop.rate.bits_64", rates.bits_64);
    rates.bits_128 = read("rop.rate.bits_128", rates.bits_128);
    rates.samples_per_cycle = read("rop.samples_per_cycle", rates.samples_per_cycle);
    return rates;
}

LaneTurns::LaneTurns(const Declaration& declaration, const SurfaceMap& map, const FormatRates& rates)
    : samples_per_cycle_(rates.samples_per_cycle),
      image_cycles_(rates.cycles(static_cast<int>(map.pixel_bytes(map.image())) * 8)) {
    for (std::size_t s = 0; s < declaration.surfaces.size(); ++s) {
        const Surface& surface = declaration.surfaces[s];
        const bool color = map.surface_class(static_cast<int>(s)) == SurfaceClass::kColor;
        const Turns of = {static_cast<std::uint32_t>(s), color ? rates.cycles(surface.element_bits) : 0};
        if (surface.layout == Layout::kPlanar && surface.elements > 1)
            sampled_.push_back(of);
        else if (of.rate > 0)
            written_.push_back(of);
    }
}

std::uint32_t LaneTurns::turns(std::uint64_t samples) const {
    return (static_cast<std::uint32_t>(count_elements(samples)) + samples_per_cycle_ - 1) /
           samples_per_cycle_;
}

}  // namespace ropsim
