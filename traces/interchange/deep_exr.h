// Deep OpenEXR both ways: a trace's fragments as the samples of a deep image, and any deep image as
// fragments. Channels, attributes and conventions are in docs/interchange.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ropsim {

// In which order the samples of a pixel of a foreign deep image arrive. Samples of one depth always keep the
// file's order among themselves, because that decides which of them is nearer.
enum class DeepOrder { kFile, kNearToFar, kFarToNear, kShuffle };

struct DeepImportOptions {
    // Given: also a file that export_deep_exr wrote is read as any other program's, by its Z, colour and A.
    std::optional<DeepOrder> order;
    std::uint64_t seed = 0;  // of kShuffle, which is what foreign files get without an order
};

// Writes all of a trace, without loss: values outside their ranges, channels and the opaque layer included.
// Holds the rows of pixels that have `band_fragments` fragments together, or one row of tiles, and reads the
// trace once for each such band. UserError beyond 2^32 fragments, or where a row of pixels holds more than
// OpenEXR can (1 GiB).
void export_deep_exr(const std::string& trace_path, const std::string& exr_path,
                     std::uint64_t band_fragments = 16u << 20);

// A file of export_deep_exr becomes the same trace, to the hash. The first deep part of any other file
// becomes fragments in rounds: the first arrival of every pixel tile by tile, then the second, and so on.
// Returns what the user should know about the conversion, a line each. Memory: 32 bytes a fragment, 72 with
// materials, 36 and 12 a pixel for a foreign file. Every fault is a UserError that names the file and, where
// there is one, the pixel in the file's coordinates.
std::vector<std::string> import_deep_exr(const std::string& exr_path, const std::string& trace_path,
                                         const DeepImportOptions& options = {});

// Whether the file starts as OpenEXR files do. False where there is no such file.
bool is_exr_file(const std::string& path);

}  // namespace ropsim
