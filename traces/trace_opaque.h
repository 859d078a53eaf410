// Turns a trace's opaque layer into fragments of alpha 1.
#pragma once

#include <cstdint>
#include <string>

namespace ropsim {

enum class OpaquePlace { kFirst, kLast };  // in arrival order: before or behind all other fragments

struct OpaqueConversion {
    std::uint64_t fragments = 0;     // made of the layer
    std::uint64_t ties_removed = 0;  // fragments that lay in all their samples at the very depth of the layer
    bool layer_left = false;         // colours remain behind samples where nothing opaque was drawn
    bool widened_colors = false;     // colours are stored as float32 now: those of the layer are no halves
};

// Writes the trace with one fragment of alpha 1 for each group of a pixel's samples in which the opaque layer
// has one colour and depth, in a draw of its own, "opaque", the last in the list. Where nothing opaque was
// drawn, the layer's colour stays behind; where something was, the trace's background is. All other fragments
// stay, those that the layer hid too: no depth test removes them any more. Each keeps its draw and primitive.
// The exact picture is the same: of the fragments at the very depth of the layer, which the depth test took
// away, those in front of it by arrival (OpaquePlace::kLast) lose the samples that lie there. Throws
// UserError where there is no opaque layer, where a fragment of a draw without depth test lies behind it (it
// would be hidden now), or when the file cannot be written.
OpaqueConversion convert_opaque(const std::string& trace_path, const std::string& out_path,
                                OpaquePlace place);

}  // namespace ropsim
