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

namespace {

// Elements of one sample where the surface has state for each, else 0. What is declared in planes is samples
// or targets of their own; side by side, elements belong to the trace's samples in equal shares.
std::uint32_t elements_of_a_sample(const Declaration& declaration, const Surface& s, int samples) {
    if (s.layout == Layout::kPool || s.elements == 1) return 0;
    if (s.layout == Layout::kPlanar) return 1;
    const bool shared_out = samples > 1 && declaration.uses_coverage && s.elements % samples == 0;
    return shared_out ? static_cast<std::uint32_t>(s.elements / samples) : 0;
}

}  // namespace

LaneTurns::LaneTurns(const Declaration& declaration, const SurfaceMap& map, const FormatRates& rates,
                     int samples)
    : samples_per_cycle_(rates.samples_per_cycle),
      image_cycles_(rates.cycles(static_cast<int>(map.pixel_bytes(map.image())) * 8)) {
    for (std::size_t s = 0; s < declaration.surfaces.size(); ++s) {
        const Surface& surface = declaration.surfaces[s];
        const bool color = map.surface_class(static_cast<int>(s)) == SurfaceClass::kColor;
        const Turns of = {static_cast<std::uint32_t>(s), color ? rates.cycles(surface.element_bits) : 0,
                          elements_of_a_sample(declaration, surface, samples)};
        if (of.rate > 0 || of.sample_elements > 0) turns_.push_back(of);
    }
}

std::uint32_t LaneTurns::turns(const Turns& of, std::uint64_t elements) const {
    const auto count = static_cast<std::uint32_t>(count_elements(elements));
    const std::uint32_t samples = (count + of.sample_elements - 1) / of.sample_elements;
    return (samples + samples_per_cycle_ - 1) / samples_per_cycle_;
}

}  // namespace ropsim
