// Piecewise capture of transparent fragments through a shader storage buffer and an atomic counter.
#include "capture/fragment_capture.h"

#include "base/error.h"
#include "base/parallel.h"
#include "capture/fragment_order.h"
#include "capture/gpu_draw.h"
#include "traces/sample_positions.h"

#include <algorithm>

namespace ropsim {
namespace {

constexpr std::size_t kHeaderBytes = 32;  // the counter, padded as in fragment_append.glsl
constexpr std::uint32_t kFirstPiecePrimitives =
    4096;  // a guess that cannot be slow; later pieces follow the yield
constexpr std::uint32_t kMaxPiecePrimitives = 1u << 22;
constexpr double kFill = 0.7;  // of the buffer, aimed at by the next piece

// What is drawn at once: whole instances, or triangles of one instance, or a block of tiles of one triangle.
struct Piece {
    DrawRange range;
    int x = 0, y = 0, width = 0, height = 0;  // scissor, pixels
};

// One of two output buffers: while the GPU fills one, the CPU orders the other's fragments.
struct Slot {
    explicit Slot(std::size_t bytes) : output(kHeaderBytes + bytes, nullptr) {
        glCreateQueries(GL_SAMPLES_PASSED, 1, &query);
    }
    ~Slot() { glDeleteQueries(1, &query); }
    Slot(const Slot&) = delete;
    Slot& operator=(const Slot&) = delete;

    GlBuffer output;
    GLuint query = 0;
    Piece piece;
};

std::string defines(const FragmentRecords& records) {
    return std::string(records.slopes ? "#define SLOPES\n" : "") +
           (records.materials ? "#define MATERIALS\n" : "");
}

class DrawCapture {
 public:
    DrawCapture(const SceneDraw& draw, std::uint16_t index, const Camera& camera, int width, int height,
                int samples, std::size_t capacity, FragmentOrder& order, FragmentRecords& staging,
                FragmentCaptureCounts& counts, const FragmentSink& sink)
        : gpu_(draw, camera, "fragment_append", defines(staging)),
          name_(draw.state.name),
          width_(width),
          height_(height),
          samples_(samples),
          capacity_(capacity),
          order_(order),
          staging_(staging),
          counts_(counts),
          sink_(sink),
          primitives_(draw.primitives),
          instances_(draw.instances) {
        gpu_.program().set("u_capacity", static_cast<std::uint32_t>(capacity));
        gpu_.program().set("u_draw", std::uint32_t{index});
    }

    void run(Slot& first, Slot& second) {
        Slot* filling = &first;
        Slot* waiting = nullptr;
        while (next_instance_ < instances_) {
            start(*filling, take_piece());
            if (waiting != nullptr) finish(*waiting);
            waiting = filling;
            filling = filling == &first ? &second : &first;
        }
        if (waiting != nullptr) finish(*waiting);
    }

 private:
    Piece take_piece();
    void start(Slot& slot, const Piece& piece) const;
    void draw_pass(const Piece& piece, SamplePosition position, std::uint32_t coverage) const;
    void finish(Slot& slot);
    std::vector<Piece> split(const Piece& piece, std::uint64_t fragments) const;

    GpuDraw gpu_;
    std::string name_;
    int width_;
    int height_;
    int samples_;
    std::size_t capacity_;
    FragmentOrder& order_;
    FragmentRecords& staging_;
    FragmentCaptureCounts& counts_;
    const FragmentSink& sink_;
    std::uint32_t primitives_;
    std::uint32_t instances_;
    std::uint32_t next_instance_ = 0;
    std::uint32_t next_primitive_ = 0;
    double piece_primitives_ = kFirstPiecePrimitives;  // how many triangles are likely to fill the buffer
};

Piece DrawCapture::take_piece() {
    const auto wanted = static_cast<std::uint32_t>(
        std::clamp(piece_primitives_, 1.0, static_cast<double>(kMaxPiecePrimitives)));
    Piece piece;
    piece.width = width_;
    piece.height = height_;
    if (next_primitive_ == 0 && wanted >= primitives_) {
        const std::uint32_t instances = std::min(wanted / primitives_, instances_ - next_instance_);
        piece.range = {next_instance_, instances, 0, primitives_};
        next_instance_ += instances;
        return piece;
    }
    const std::uint32_t primitives = std::min(wanted, primitives_ - next_primitive_);
    piece.range = {next_instance_, 1, next_primitive_, primitives};
    next_primitive_ += primitives;
    if (next_primitive_ == primitives_) {
        next_primitive_ = 0;
        ++next_instance_;
    }
    return piece;
}

// Draws with `position` moved onto the pixels' centres.
void DrawCapture::draw_pass(const Piece& piece, SamplePosition position, std::uint32_t coverage) const {
    gpu_.program().set("u_coverage", coverage);
    gpu_.set_sample_position(position, width_, height_);
    gpu_.submit(piece.range);
}

void DrawCapture::start(Slot& slot, const Piece& piece) const {
    slot.piece = piece;
    const std::uint32_t zero = 0;
    glNamedBufferSubData(slot.output.id(), 0, sizeof zero, &zero);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, slot.output.id());
    glScissor(piece.x, piece.y, piece.width, piece.height);
    glBeginQuery(GL_SAMPLES_PASSED, slot.query);
    if (samples_ == 1) {
        draw_pass(piece, {0, 0}, 1);
    } else {
        draw_pass(piece, {0, 0}, 0);
        std::uint32_t bit = 1;
        for (const SamplePosition position : sample_positions(samples_)) {
            draw_pass(piece, position, bit);
            bit <<= 1;
        }
    }
    glEndQuery(GL_SAMPLES_PASSED);
    glFlush();
}

void DrawCapture::finish(Slot& slot) {
    const Piece piece = slot.piece;
    GLuint64 samples = 0;
    glGetQueryObjectui64v(slot.query, GL_QUERY_RESULT, &samples);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    std::uint32_t count = 0;
    glGetNamedBufferSubData(slot.output.id(), 0, sizeof count, &count);
    check_gl("drawing the transparent fragments");
    if (count != samples) {
        throw UserError(name_,
                        fmt::format("the OpenGL driver appended {} fragments but rasterised {}; try another "
                                    "driver, e.g. ROPSIM_GL=surfaceless",
                                    count, samples));
    }
    const double primitives = static_cast<double>(piece.range.primitives) * piece.range.instances;
    const double filling = kFill * static_cast<double>(capacity_) * primitives / std::max<double>(count, 1.0);
    piece_primitives_ = std::min(filling, 8 * std::max(piece_primitives_, primitives));
    if (count > capacity_) {
        ++counts_.retries;
        for (const Piece& part : split(piece, count)) {
            start(slot, part);
            finish(slot);
        }
        return;
    }
    staging_.words.resize(count * staging_.record_words());
    if (count > 0) {
        glGetNamedBufferSubData(slot.output.id(), kHeaderBytes,
                                static_cast<GLsizeiptr>(staging_.words.size() * sizeof(std::uint32_t)),
                                staging_.words.data());
        const std::uint64_t first =
            std::uint64_t{piece.range.first_instance} * primitives_ + piece.range.first_primitive;
        const FragmentChunk& fragments =
            order_.sort(staging_, first, piece.range.primitives * piece.range.instances);
        if (!fragments.empty()) sink_(fragments);
        counts_.fragments += fragments.size();
    }
    ++counts_.pieces;
}

// Two or more smaller pieces that follow one another in canonical order.
std::vector<Piece> DrawCapture::split(const Piece& piece, std::uint64_t fragments) const {
    const auto parts = static_cast<std::uint32_t>(
        static_cast<double>(fragments) / (kFill * static_cast<double>(capacity_)) + 1.0);
    std::vector<Piece> pieces;
    const auto cut = [&](std::uint32_t first, std::uint32_t count, auto&& assign) {
        const std::uint32_t step = std::max(count / parts, 1u);
        for (std::uint32_t done = 0; done < count; done += step) {
            pieces.push_back(piece);
            assign(pieces.back(), first + done, std::min(step, count - done));
        }
    };
    if (piece.range.instances > 1) {
        cut(piece.range.first_instance, piece.range.instances,
            [](Piece& part, std::uint32_t at, std::uint32_t n) {
                part.range.first_instance = at;
                part.range.instances = n;
            });
    } else if (piece.range.primitives > 1) {
        cut(piece.range.first_primitive, piece.range.primitives,
            [](Piece& part, std::uint32_t at, std::uint32_t n) {
                part.range.first_primitive = at;
                part.range.primitives = n;
            });
    } else if (piece.height > kTileSize) {
        const auto rows = static_cast<std::uint32_t>((piece.height + kTileSize - 1) / kTileSize);
        cut(0, rows, [&](Piece& part, std::uint32_t at, std::uint32_t n) {
            part.y = piece.y + static_cast<int>(at) * kTileSize;
            part.height = std::min(static_cast<int>(n) * kTileSize, piece.y + piece.height - part.y);
        });
    } else {
        CHECK(piece.width > kTileSize, "one triangle gave {} fragments in a tile", fragments);
        const auto columns = static_cast<std::uint32_t>((piece.width + kTileSize - 1) / kTileSize);
        cut(0, columns, [&](Piece& part, std::uint32_t at, std::uint32_t n) {
            part.x = piece.x + static_cast<int>(at) * kTileSize;
            part.width = std::min(static_cast<int>(n) * kTileSize, piece.x + piece.width - part.x);
        });
    }
    return pieces;
}

// In records.
std::size_t piece_capacity(const FragmentCaptureLimits& limits, std::size_t record_bytes, int passes) {
    GLint driver_limit = 0;
    glGetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &driver_limit);
    const std::size_t allowed = (static_cast<std::size_t>(driver_limit) - kHeaderBytes) / record_bytes;
    const std::size_t wanted = limits.fragments_a_piece == 0 ? kMaxPieceFragments : limits.fragments_a_piece;
    const std::size_t capacity = std::min(wanted, allowed);
    const auto tile = static_cast<std::size_t>(kTilePixels * passes);
    CHECK(capacity >= tile, "{} records a piece; a tile may have {}", capacity, tile);
    return capacity;
}

}  // namespace

FragmentCaptureCounts capture_fragments(const Scene& scene, int width, int height, int samples,
                                        const FragmentCaptureLimits& limits, const FragmentSink& sink) {
    FragmentRecords staging;
    staging.slopes = samples > 1;
    staging.materials = scene.materials;
    const std::size_t record_bytes = staging.record_words() * sizeof(std::uint32_t);
    const std::size_t capacity = piece_capacity(limits, record_bytes, samples > 1 ? samples + 1 : 1);
    const GlTarget target(width, height, GL_NONE, false);
    target.bind();
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glEnable(GL_SCISSOR_TEST);
    Slot first(capacity * record_bytes);
    Slot second(capacity * record_bytes);
    FragmentOrder order(width, samples, limits.threads > 0 ? limits.threads : default_threads());
    FragmentCaptureCounts counts;
    for (std::size_t i = 0; i < scene.transparent.size(); ++i) {
        const SceneDraw& draw = scene.transparent[i];
        const std::uint64_t primitives = std::uint64_t{draw.primitives} * draw.instances;
        if (primitives > kBackFacing) {
            throw UserError("--fragments",
                            "the scene would have more than 2^31 triangles; ask for fewer fragments");
        }
        if (primitives == 0) continue;
        DrawCapture(draw, static_cast<std::uint16_t>(i), scene.camera, width, height, samples, capacity,
                    order, staging, counts, sink)
            .run(first, second);
    }
    glDisable(GL_SCISSOR_TEST);
    return counts;
}

}  // namespace ropsim
