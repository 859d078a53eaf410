// A technique's declaration and its charged run.
#include "analysis/claims/declared_cost.h"

#include "model/machine_config.h"
#include "rop/registry.h"

namespace ropsim {

int DeclaredCost::surface_bits(const std::string& name) const {
    for (const Surface& surface : declaration.surfaces)
        if (surface.name == name) return surface.bits_per_pixel();
    return 0;
}

DeclaredCost declared_cost(const std::string& technique, int spatial_samples, bool materials) {
    TechniqueSpec spec = parse_technique(technique, "technique");
    const auto operation =
        make_operation(spec, {.samples = spatial_samples, .camera = Camera{}, .materials = materials});
    // Bytes do not depend on the datapath's shape.
    Parameters hardware = hardware_parameters("desktop");
    const MachineConfig config = machine_config(hardware, "desktop");
    DeclaredCost cost;
    cost.declaration = operation->declaration();
    cost.storage_bits = cost.declaration.storage_bits_per_pixel();
    cost.worst_case = worst_case_bytes(cost.declaration, operation->cost(config.datapath));
    const Repeat& repeat = cost.declaration.repeat;
    for (int pass = 0; pass < static_cast<int>(cost.declaration.passes.size()); ++pass) {
        if (cost.declaration.passes[static_cast<std::size_t>(pass)].kind != PassKind::kGeometry) continue;
        cost.geometry_passes += pass >= repeat.first && pass <= repeat.last ? repeat.rounds : 1;
    }
    return cost;
}

}  // namespace ropsim
