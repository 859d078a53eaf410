// What one operation moves at worst on a control path.
#pragma once

#include "rop/cost.h"
#include "rop/declaration.h"

namespace ropsim {

// Over all surfaces, when every predicated access happens and nothing is cached.
inline ByteCount path_bytes(const Declaration& declaration, const PathCost& path) {
    ByteCount bytes;
    for (std::size_t s = 0; s < declaration.surfaces.size(); ++s) {
        bytes.read += access_bytes(declaration.surfaces[s], path.worst[s].read);
        bytes.write += access_bytes(declaration.surfaces[s], path.worst[s].write);
    }
    return bytes;
}

}  // namespace ropsim
