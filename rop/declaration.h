// What a technique declares about itself: surfaces, passes, order. Bits per pixel, clear, copy and resolve
// traffic follow from it.
#pragma once

#include "base/error.h"
#include "rop/format.h"
#include "rop/shader_stage.h"
#include "rop/stored_word.h"
#include "rop/value_range.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// How the elements of a surface lie in memory (rop/ names bytes of a pixel, model/ places them).
enum class Layout : std::uint8_t {
    kInterleaved,  // all elements of a pixel side by side
    kPlanar,       // a plane of the tile for each element, as multisampled targets are kept
    kPool,         // nodes allocated in arrival order, shared by all pixels of a partition
};

enum class Initial : std::uint8_t {
    kClear,         // a constant; with fast clear it costs nothing until the first write-back
    kOpaqueColor,   // the opaque layer's colour, copied into every element (counted)
    kOpaqueDepth,   // the opaque layer's depth, copied into every element (counted)
    kOpaqueTarget,  // the surface is the opaque layer's own colour target: nothing to copy
};

// Handle of one field of a surface's elements: where its words are in a pixel's functional state and how it
// is stored. Words hold values already rounded to the stored format, one 32-bit word a channel. The state
// keeps the same field of all elements side by side, whatever the layout in memory, so that vector code can
// load it.
struct Field {
    std::uint16_t first_word = 0;  // of element 0, channel 0
    std::uint16_t stride = 0;      // words of this field an element: its channels
    std::uint8_t surface = 0;
    std::uint8_t channels = 1;
    Format format = Format::kFloat32;
};

// One field of an element: `channels` values of one format with a common clear value.
struct FieldSpec {
    Format format = Format::kFloat32;
    int channels = 1;
    std::uint32_t clear = 0;  // functional word, in every channel
    int bit_count = 0;        // of Format::kBits: all channels together, 32 a word
    ValueRange range = ValueRange::kUnit;

    static FieldSpec real(Format format, int channels, float clear, ValueRange range) {
        return {format, channels, stored_word(stored_value(format, clear)), 0, range};
    }
    // `range`: of packed values; a plain integer holds what it counts.
    static FieldSpec integer(int bits, std::uint32_t clear, ValueRange range = ValueRange::kUnit) {
        return {Format::kBits, bits > 32 ? 2 : 1, clear, bits, range};
    }
    int bits() const {
        if (format == Format::kBits) return bit_count;
        const bool packed = format == Format::kR11G11B10 || format == Format::kRgb9e5;
        return format_info(format).bits * (packed ? 1 : channels);
    }
};

// A field of an element as it lies in memory, behind the ones before it without gaps.
struct StoredField {
    int first_word = 0;  // functional words of element 0, in the surface's; of the next ones `channels` on
    int channels = 1;
    Format format = Format::kFloat32;
    int bits = 0;  // all channels together
    ValueRange range = ValueRange::kUnit;
};

struct Surface {
    std::string name;
    int elements = 1;  // a pixel: stored samples, nodes or 1; for pools 1
    Layout layout = Layout::kInterleaved;
    Initial initial = Initial::kClear;
    Format format = Format::kFloat32;        // of the first field: how the opaque layer is stored into it
    int element_bits = 0;                    // sum over fields, as claimed
    int words = 0;                           // functional words of all elements
    int first_word = 0;                      // in the pixel's state; for pools in the node
    std::vector<std::uint32_t> clear_words;  // the clear value of each word
    std::vector<Format> word_formats;        // what each word is stored as
    std::vector<StoredField> fields;         // of an element
    int first_channels = 0;                  // words an element of the first field
    // 1, or how many pixels of the image a pixel of the surface spans in each direction: only the corner of
    // the image's size over `scale` is used, as a smaller viewport of the target would.
    int scale = 1;
    // Pixels around its own that a resolve which gathers reads of this surface at most; of one of lower
    // resolution, an image pass.
    int gathered = 0;
    // Elements are written at addresses that depend on the pixel's state: of a path's worst case the number
    // of elements holds, not which they are.
    bool addressed = false;

    int element_bytes() const { return (element_bits + 7) / 8; }
    // Of the image.
    int bits_per_pixel() const {
        return layout == Layout::kPool ? 0 : (element_bits * elements + scale * scale - 1) / (scale * scale);
    }
};

// The pixel of the image at which a surface, or a pass, of lower resolution has its sample.
constexpr int full_resolution(int at, int scale) {
    return at * scale + scale / 2;
}
// How many such samples an image of `size` pixels has.
constexpr int low_resolution(int size, int scale) {
    return scale == 1 ? size : (size + scale - 1 - scale / 2) / scale;
}

enum class Shading : std::uint8_t { kAlphaOnly, kFull };

enum class PassKind : std::uint8_t {
    kGeometry,  // over the transparent fragments
    kImage,     // over the pixels of touched tiles, between two passes over fragments
};

struct Pass {
    std::string name;
    Shading shading = Shading::kFull;
    PassKind kind = PassKind::kGeometry;
    // Surfaces that are set to their initial contents before the pass, in every round but the first, where
    // they have them already. Counted like any other write.
    std::vector<int> restores = {};
    // Drawn, or gone over, at a resolution lower by this factor in each direction (see Surface::scale).
    int scale = 1;
    // By draw of the trace: whether the pass takes its fragments. Empty: all. Passes that choose draws choose
    // each of them once.
    std::vector<std::uint8_t> draws = {};
    bool gathers = false;  // an image pass that reads pixels around its own
};

// Passes first..last are run again as long as control path `path` was taken in the round before (as an
// occlusion query tells a driver), at most `rounds` times in all; without a path, exactly so often.
struct Repeat {
    int first = 0;
    int last = -1;
    int rounds = 1;
    int path = -1;
};

// What becomes of light, whatever the formats. Light without alpha hides nothing: it comes on top.
enum class LightLaw : std::uint8_t {
    // Layers under what those in front of them let through: nothing comes out brighter than the brightest of
    // fragments and background.
    kLayers,
    // The same of a weighted mean of colours over the total alpha, whatever its transmittances are rounded
    // to.
    kMean,
    kConserved,  // no more comes out than fragments and background have, none behind another
    // A mean of light that has alpha. Resolve scales the sum of all light to the pixel's total alpha, and of
    // that sum light without alpha has a part while in the sum of weights it has none: it may grow brighter.
    kScaled,
    kAdded,  // a published form that adds light, kept to be shown
};

// How the samples of an image become a pixel of the display. A linear filter of ST 2011, section 3.5.
enum class DisplayFilter : std::uint8_t { kBox, kGaussian };

enum class Ordering : std::uint8_t {
    kRaster,  // operations on a pixel must happen in raster order
    kAny,     // any order gives the same result up to ties and rounding; atomic per pixel all the same
};

inline constexpr int kMaxTechniqueSurfaces = 9;
inline constexpr int kMaxElements = 64;

struct Declaration {
    std::vector<Surface> surfaces;
    std::vector<Pass> passes;
    std::vector<std::string> paths;  // names of the control paths, fragment's and resolve's
    Ordering ordering = Ordering::kRaster;
    bool zero_alpha_harmless =
        true;              // a fragment with zero alpha and colour may be dropped before the operation
    bool resolves = true;  // false: the image is surface 0 itself, nothing is read or written at the end
    bool resolve_reads_background = true;
    Format image_format = Format::kFloat16;  // of the resolved image's four channels
    bool uses_coverage = false;              // handles fragments that cover some of a trace's spatial samples
    bool random = false;                     // the image depends on the seed
    LightLaw light = LightLaw::kLayers;
    Repeat repeat;
    bool gathers = false;         // resolve reads pixels at places it computes
    int background_gathered = 0;  // how many of the opaque layer's colours it then reads at most
    // Of surfaces of lower resolution: pixels of theirs that an image pass or resolve reads around the one
    // that spans its own, in each direction.
    int low_resolution_reach = 0;
    // By draw of the trace: fragments of it that follow one another at a pixel are joined in the shader's
    // registers and exported once (see Technique::joined). Empty: none.
    std::vector<std::uint8_t> joined_draws = {};
    int footprint = 0;              // pixels around its own that resolve reads, in each direction
    int background_footprint = 0;   // the same of the opaque layer's colour
    bool shades_materials = false;  // its shader goes by the fragments' materials
    // Though it does, it knows nothing of transmission: fragments have the least alpha that means the same.
    bool knows_alpha_alone = false;
    AddedShading added_shading;
    DisplayFilter display_filter = DisplayFilter::kBox;
    bool image_is_color = true;  // false: nothing the reference image could be compared with
    // Knows what each channel of a fragment lets through: compared with the reference of coloured
    // transmission.
    bool colored_transmission = false;
    int pixel_words = 0;  // functional state of a pixel
    int node_words = 0;   // functional state of a pool node

    // Declares a surface of `elements` elements a pixel and returns a handle for each field.
    std::vector<Field> surface(const std::string& name, int elements, Layout layout, Initial initial,
                               const std::vector<FieldSpec>& fields, int scale = 1) {
        CHECK(surfaces.size() < kMaxTechniqueSurfaces, "{} surfaces", surfaces.size());
        CHECK(elements >= 1 && elements <= kMaxElements, "{} elements", elements);
        Surface s;
        s.name = name;
        s.elements = elements;
        s.layout = layout;
        s.initial = initial;
        s.format = fields.front().format;
        s.scale = scale;
        int& total_words = layout == Layout::kPool ? node_words : pixel_words;
        s.first_word = total_words;
        s.first_channels = fields.front().channels;
        std::vector<Field> handles;
        for (const FieldSpec& spec : fields) {
            handles.push_back({static_cast<std::uint16_t>(s.first_word + s.words),
                               static_cast<std::uint16_t>(spec.channels),
                               static_cast<std::uint8_t>(surfaces.size()),
                               static_cast<std::uint8_t>(spec.channels), spec.format});
            s.fields.push_back({s.words, spec.channels, spec.format, spec.bits(), spec.range});
            s.words += spec.channels * elements;
            s.element_bits += spec.bits();
            const auto words = static_cast<std::size_t>(spec.channels * elements);
            s.clear_words.insert(s.clear_words.end(), words, spec.clear);
            s.word_formats.insert(s.word_formats.end(), words, spec.format);
        }
        total_words += s.words;
        surfaces.push_back(std::move(s));
        return handles;
    }

    int storage_bits_per_pixel() const {
        int bits = 0;
        for (const Surface& s : surfaces) bits += s.bits_per_pixel();
        return bits;
    }
    // Of lists: what a stored fragment takes on top of that.
    int storage_bits_per_node() const {
        int bits = 0;
        for (const Surface& s : surfaces) bits += s.layout == Layout::kPool ? s.element_bits : 0;
        return bits;
    }
    int path(std::string_view name) const {
        for (std::size_t i = 0; i < paths.size(); ++i)
            if (paths[i] == name) return static_cast<int>(i);
        return -1;
    }
};

}  // namespace ropsim
