// The program's version, written into every result.
#pragma once

namespace ropsim {
inline constexpr const char* kVersion = "0.1.0";
}
