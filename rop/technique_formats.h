// The format keys that every technique takes: format=paper|float32, and <surface>_format=NAME for one
// surface.
#pragma once

#include "base/parameters.h"
#include "rop/format.h"

#include <string>

namespace ropsim {

class TechniqueFormats {
 public:
    explicit TechniqueFormats(Parameters& parameters)
        : parameters_(parameters),
          float32_(parameters.get_choice("format", "paper", {"paper", "float32"}) == "float32") {}

    // Whether nothing is to be rounded but what a format key of its own names.
    bool float32() const { return float32_; }
    // What `<surface>_format` names, else float32 under format=float32, else `paper`.
    Format of(const std::string& surface, Format paper) const { return choose(surface, paper, false); }
    // The same for a colour whose alpha nothing reads: the formats that pack three channels in 32 bits will
    // do too.
    Format rgb(const std::string& surface, Format paper) const { return choose(surface, paper, true); }
    // The resolved image: binary16, as a display pipeline takes it, or exact under format=float32.
    Format image() const { return rgb("image", Format::kFloat16); }

 private:
    Format choose(const std::string& surface, Format paper, bool packed) const;

    Parameters& parameters_;
    bool float32_;
};

}  // namespace ropsim
