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

// What a fragment of a draw costs to shade.
struct ShaderCost {
    std::uint32_t alu_instructions = 0;
    std::uint32_t texture_fetches = 0;
    std::uint32_t texture_bytes = 0;  // texels that all its fetches read, before any cache
};

enum class BlendMode { kOver, kAdditive, kMultiply };  // as the application set it; techniques may ignore it
enum class CullMode { kNone, kBack, kFront };

// State of one draw call of transparent geometry.
struct Draw {
    std::string name;
    std::uint32_t object_id = 0;
    bool depth_test = true;  // tested against the opaque layer, nearer passes (GL_LESS)
    bool depth_write = false;
    BlendMode blend = BlendMode::kOver;
    CullMode cull = CullMode::kNone;
    ShaderCost full{16, 0, 0};            // of the whole shader
    ShaderCost alpha{4, 0, 0};            // of what remains of it when only alpha is wanted
    std::string cost_source = "default";  // where the two come from, one line
};

// The image behind the transparent fragments, per spatial sample: sample m of pixel i is element i * M + m.
struct OpaqueLayer {
    std::vector<float> rgb;    // width * height * M * 3, linear, row-major from the top left
    std::vector<float> depth;  // width * height * M; +infinity where nothing opaque was drawn
};

enum class ColorStorage { kFloat32, kFloat16 };

struct TraceHeader {
    int width = 0;               // 1..16384
    int height = 0;              // 1..16384
    int samples = 1;             // M spatial samples a pixel: 1, 2, 4, 8 or 16
    glm::vec3 background{0.0f};  // linear; the opaque colour where `opaque` is absent
    ColorStorage color_storage =
        ColorStorage::kFloat32;    // what r, g, b are stored as; alpha and z are float32
    std::string scene;             // what was captured, one line
    std::string view = "camera";   // or "light": seen from the scene's light, for shadow maps
    std::optional<Camera> camera;  // of this view
    std::optional<Camera> light;   // of the light, in the same world
    std::vector<Draw> draws;
    std::optional<OpaqueLayer> opaque;  // absent: background colour everywhere, nothing opaque in front
    bool depth_slopes = false;          // every fragment has a DepthSlope
    bool materials = false;             // every fragment has a Material
    // Fragments may hold NaN and infinity, and alpha and depth outside [0, 1], as shaders can produce them.
    bool non_finite = false;
};

// How a fragment's depth plane falls away from the pixel's centre: z of a sample at (x, y), in pixels from
// the centre with y down, is z + dx * x + dy * y, clamped to [0, 1].
struct DepthSlope {
    float dx = 0;
    float dy = 0;
};

// What a surface does to light besides covering: the inputs of phenomenological transparency (McGuire and
// Mara 2017, section 4). Stored like colour: as halves with ColorStorage::kFloat16.
struct Material {
    float transmission[3] = {0, 0, 0};  // of the covered part, per channel
    float collimation = 1;              // 1: passes light straight on, 0: scatters it entirely
    float eta = 1;                      // index of refraction
    float normal[3] = {0, 0, 1};        // unit length, camera space: +x right, +y up, +z towards the eye
};

enum ChannelSet : unsigned { kNoChannels = 0, kSlopeChannels = 1, kMaterialChannels = 2, kAllChannels = 3 };
// Asked for with the channels: alpha for those who do not look at materials (traces/least_alpha.h).
inline constexpr unsigned kLeastAlpha = 4;

// What a trace may know of one fragment besides the fragment itself; as here where it does not.
struct FragmentChannels {
    DepthSlope slope = {};
    Material material = {};
};

// Consecutive fragments with what the trace knows about them; `slopes` and `materials` are empty or as long
// as `fragments`.
struct FragmentChunk {
    std::vector<Fragment> fragments;
    std::vector<DepthSlope> slopes;
    std::vector<Material> materials;

    std::size_t size() const { return fragments.size(); }
    bool empty() const { return fragments.empty(); }
    void clear() {
        fragments.clear();
        slopes.clear();
        materials.clear();
    }
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
    // With the channels that the header announces, and no others (CHECK). The overloads above give a trace
    // with channels their defaults.
    void append(const FragmentChunk& chunk);
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
    // Where the header says non_finite, values are brought into range as a raster-operation unit's input
    // stage would: a NaN depth becomes 1, alpha 0, colour 0; infinite colours become +-65504; depth and alpha
    // are clamped.
    bool next(std::vector<Fragment>& fragments);
    // The same with those of the channels in `wanted` (ChannelSet) that the trace has; the others are not
    // decoded. With kLeastAlpha fragments that transmit have the least alpha that means the same.
    bool next(FragmentChunk& chunk, unsigned wanted = kAllChannels);
    // The same with all channels as stored, whatever the values.
    bool next_raw(FragmentChunk& chunk);
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
