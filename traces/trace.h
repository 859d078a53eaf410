// What a trace holds besides its fragments, and the interfaces that read and write it.
#pragma once

#include "traces/fragment.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// Perspective or other camera of the captured view.
struct Camera {
    glm::mat4 view{1.0f};        // world to camera
    glm::mat4 projection{1.0f};  // camera to clip, OpenGL conventions
    float near_plane = 0;        // camera-space distance, scene units
    float far_plane = 0;
    float fovy_degrees = 0;
    float metres_per_unit = 1;  // scene units to metres
};

// State of one draw call of transparent geometry.
struct Draw {
    std::string name;
    std::uint32_t object_id = 0;
    bool depth_test = true;  // tested against the opaque layer, nearer passes (GL_LESS)
    bool depth_write = false;
    bool cull_back_faces = false;
    // Cost of the draw's shaders per fragment: the full one, and the one that needs only alpha.
    std::uint32_t full_alu_instructions = 16;
    std::uint32_t full_texture_fetches = 0;
    std::uint32_t alpha_alu_instructions = 4;
    std::uint32_t alpha_texture_fetches = 0;
};

// The image behind the transparent fragments: one sample a pixel.
struct OpaqueLayer {
    std::vector<float> rgb;    // width * height * 3, linear, row-major from the top left
    std::vector<float> depth;  // width * height; +infinity where nothing opaque was drawn
};

enum class ColorStorage { kFloat32, kFloat16 };

struct TraceHeader {
    int width = 0;               // 1..16384
    int height = 0;              // 1..16384
    int samples = 1;             // M spatial samples a pixel: 1, 2, 4, 8 or 16
    glm::vec3 background{0.0f};  // linear; the opaque colour where `opaque` is absent
    ColorStorage color_storage =
        ColorStorage::kFloat32;  // what r, g, b are stored as; alpha and z are float32
    std::string scene;           // what was captured, one line
    std::optional<Camera> camera;
    std::vector<Draw> draws;
    std::optional<OpaqueLayer> opaque;  // absent: background colour everywhere, nothing opaque in front
};

// Number of 8x8 tiles across and down.
inline int tiles_across(int width) {
    return (width + kTileSize - 1) / kTileSize;
}

// How a trace is cut into pieces; none of it changes the trace's content or hash.
struct TraceLayoutOptions {
    int chunk_fragments = 1 << 18;  // 1..2^18
    int region_side = 128;  // pixels, 8..256, a multiple of 8: what a reader of few tiles decodes at least
};

// Writes a trace file (docs/trace-format.md) chunk by chunk: memory does not grow with its length. Fragments
// are appended in arrival order; a helper thread compresses one chunk while the next is filled. The file
// appears under `path` at finish() and not before; destroying an unfinished writer leaves nothing. Throws
// UserError when the file system refuses, or the header or a fragment holds what a trace cannot (a size,
// depth, alpha or colour out of range).
class TraceWriter {
 public:
    TraceWriter(const std::string& path, TraceHeader header, TraceLayoutOptions layout = {});
    ~TraceWriter();
    // Fragments must lie inside the image, name an existing draw and cover existing samples (CHECK). z and a
    // must be in [0, 1], colours finite (UserError). With ColorStorage::kFloat16, r, g, b are rounded to the
    // nearest half (ties to even; at most 65504): what is read back, and hashed, is the rounded value.
    void append(const Fragment* fragments, std::size_t count);
    void append(const std::vector<Fragment>& fragments) { append(fragments.data(), fragments.size()); }
    void finish();

 private:
    struct State;
    std::unique_ptr<State> state_;
};

// Reads a trace file in arrival order. Every fault in the file (truncated, corrupted, other version,
// nonsensical header) is a UserError naming file and place. Opening reads header, opaque layer and index
// only.
class TraceReader {
 public:
    explicit TraceReader(const std::string& path);
    ~TraceReader();
    TraceReader(TraceReader&&) noexcept;
    TraceReader& operator=(TraceReader&&) noexcept;

    const std::string& path() const;
    const TraceHeader& header() const;
    std::uint64_t fragment_count() const;
    std::uint64_t file_bytes() const;
    // 16 hex digits over everything that defines the trace's content (header, opaque layer, fragments),
    // independent of chunking, compression and color_storage. Verified at the end of the first complete pass
    // over the fragments.
    const std::string& hash() const;
    // Fragments in each 8x8 tile, row-major, from the index.
    const std::vector<std::uint64_t>& tile_fragments() const;

    // Replaces `fragments` by the next chunk (up to about 2^18), in arrival order; false at the end.
    bool next(std::vector<Fragment>& fragments);
    // Only fragments of tiles with selected[tile] != 0 are returned (still in arrival order); blocks of the
    // file without such a tile are not decoded. An empty vector selects all. Takes effect from the next
    // rewind().
    void select_tiles(std::vector<std::uint8_t> selected);
    // Starts again from the first fragment (the next pass).
    void rewind();
    // Blocks decoded so far, over all passes.
    std::uint64_t decoded_blocks() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ropsim
