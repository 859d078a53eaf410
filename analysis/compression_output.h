// A study of compression for programs and for readers.
#pragma once

#include "analysis/compression_study.h"

#include <string>

namespace ropsim {

// One object with every number, "units" saying what each is in. Same inputs, same text.
std::string compression_json(const CompressionStudy& study);
// One line a scene, technique, setup and surface under a heading.
std::string compression_csv(const CompressionStudy& study);
// Two tables a scene as aligned plain text: what a technique's whole frame saves by setup, and every surface
// with every codec of its class, those that lose first; below them what was refused.
std::string compression_table(const CompressionStudy& study);

}  // namespace ropsim
