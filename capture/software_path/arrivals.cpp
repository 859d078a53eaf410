#include "capture/software_path/arrivals.h"

#include "base/error.h"
#include "capture/gpu_draw.h"
#include "capture/shader_sources.h"
#include "traces/sample_positions.h"

#include <limits>
#include <optional>
#include <vector>

namespace ropsim {
namespace {

constexpr GLuint kDepthUnit = 8;
constexpr GLuint kColorUnit = 9;
constexpr GLuint kDrawFacts = 3;

std::vector<std::uint32_t> draw_facts(const TraceHeader& header) {
    std::vector<std::uint32_t> facts;
    for (const Draw& draw : header.draws) facts.push_back(2 * draw.object_id + (draw.depth_test ? 1 : 0));
    if (facts.empty()) facts.push_back(0);
    return facts;
}

// Layer m holds `channels` values a pixel of spatial sample m.
void upload_samples(GLuint texture, GLenum format, GLenum layout, std::size_t channels,
                    const TraceHeader& header, const std::vector<float>& values) {
    const auto samples = static_cast<std::size_t>(header.samples);
    const std::size_t pixels = values.size() / (samples * channels);
    glTextureStorage3D(texture, 1, format, header.width, header.height, header.samples);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    std::vector<float> layer(pixels * channels);
    for (std::size_t m = 0; m < samples; ++m) {
        for (std::size_t i = 0; i < pixels; ++i)
            for (std::size_t c = 0; c < channels; ++c)
                layer[i * channels + c] = values[(i * samples + m) * channels + c];
        glTextureSubImage3D(texture, 0, 0, 0, static_cast<GLint>(m), header.width, header.height, 1, layout,
                            GL_FLOAT, layer.data());
    }
    check_gl("uploading the opaque layer");
}

OpaqueLayer opaque_layer(const TraceHeader& header) {
    if (header.opaque) return *header.opaque;
    OpaqueLayer layer;
    const auto count = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height) *
                       static_cast<std::size_t>(header.samples);
    layer.depth.assign(count, std::numeric_limits<float>::infinity());
    layer.rgb.reserve(3 * count);
    for (std::size_t i = 0; i < count; ++i)
        for (const float c : {header.background.r, header.background.g, header.background.b})
            layer.rgb.push_back(c);
    return layer;
}

}  // namespace

Arrivals::Arrivals(const TraceHeader& header)
    : header_(&header),
      draw_facts_(draw_facts(header).size() * sizeof(std::uint32_t), draw_facts(header).data()) {
    const OpaqueLayer layer = opaque_layer(header);
    upload_samples(depth_.id, GL_R32F, GL_RED, 1, header, layer.depth);
    upload_samples(color_.id, GL_RGB32F, GL_RGB, 3, header, layer.rgb);
}

std::string Arrivals::whole(const ArrivalText& text, const char* arrival) const {
    std::string all;
    if (header_->depth_slopes) all += "#define SLOPES\n";
    if (header_->materials) all += "#define MATERIALS\n";
    if (text.reads_materials) all += "#define READS_MATERIALS\n";
    all += shader_source("arrival");
    all += shader_source(arrival);
    return all + text.text;
}

void Arrivals::set_shared(const GlProgram& program) const {
    program.set("u_samples", static_cast<std::uint32_t>(samples()));
    std::vector<glm::vec4> positions;
    for (const SamplePosition p : sample_positions(samples())) positions.emplace_back(p.x(), p.y(), 0, 0);
    program.set("u_sample_positions", positions.data(), static_cast<int>(positions.size()));
}

void Arrivals::bind_shared() const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kDrawFacts, draw_facts_.id());
    glBindTextureUnit(kDepthUnit, depth_.id);
    glBindTextureUnit(kColorUnit, color_.id);
}

namespace {

class GeometryArrivals : public Arrivals {
 public:
    GeometryArrivals(const Scene& scene, const TraceHeader& header) : Arrivals(header), scene_(&scene) {
        CHECK(header.samples == 1, "{} samples", header.samples);
    }
    const char* kind() const override { return "geometry"; }
    std::unique_ptr<ArrivalPass> pass(const ArrivalText& text) override;

 private:
    class Pass;
    const Scene* scene_;
};

class GeometryArrivals::Pass : public ArrivalPass {
 public:
    Pass(const GeometryArrivals& owner, const FragmentText& text) : owner_(owner) {
        std::uint32_t start = 0;
        for (std::size_t i = 0; i < owner.scene_->transparent.size(); ++i) {
            const SceneDraw& draw = owner.scene_->transparent[i];
            if (draw.primitives == 0) continue;
            const GlProgram& program =
                draws_.emplace_back(std::make_unique<GpuDraw>(draw, owner.scene_->camera, text))->program();
            program.set("u_draw", static_cast<std::uint32_t>(i));
            program.set("u_draw_start", start);
            owner.set_shared(program);
            start += draw.primitives * draw.instances;
        }
    }
    void set(const char* name, std::uint32_t value) override { set_all(name, value); }
    void set(const char* name, const glm::vec4& value) override { set_all(name, value); }
    void set(const char* name, const glm::mat4& value) override { set_all(name, value); }
    void draw() override {
        owner_.bind_shared();
        for (const auto& draw : draws_) draw->submit(draw->everything());
        glDisable(GL_CULL_FACE);
        check_gl("drawing the scene");
    }

 private:
    template <class Value>
    void set_all(const char* name, const Value& value) {
        for (const auto& draw : draws_) draw->program().set(name, value);
    }
    const GeometryArrivals& owner_;
    std::vector<std::unique_ptr<GpuDraw>> draws_;
};

std::unique_ptr<ArrivalPass> GeometryArrivals::pass(const ArrivalText& text) {
    return std::make_unique<Pass>(*this, FragmentText{text.directives, whole(text, "arrival_of_geometry")});
}

class ReplayedArrivals : public Arrivals {
 public:
    explicit ReplayedArrivals(TraceReader& trace) : Arrivals(trace.header()), trace_(trace) {
        glCreateVertexArrays(1, &vertex_array_);
    }
    ~ReplayedArrivals() override { glDeleteVertexArrays(1, &vertex_array_); }
    ReplayedArrivals(const ReplayedArrivals&) = delete;
    ReplayedArrivals& operator=(const ReplayedArrivals&) = delete;
    const char* kind() const override { return "fragments"; }
    std::unique_ptr<ArrivalPass> pass(const ArrivalText& text) override;

 private:
    class Pass;
    TraceReader& trace_;
    GLuint vertex_array_ = 0;
};

class ReplayedArrivals::Pass : public ArrivalPass {
 public:
    Pass(ReplayedArrivals& owner, const ArrivalText& text)
        : owner_(owner),
          program_("replayed fragments", shader_source("replay_vertex"), {},
                   owner.whole(text, "arrival_of_replay"), text.directives),
          channels_(kSlopeChannels | (text.reads_materials ? kMaterialChannels : kLeastAlpha)) {
        owner.set_shared(program_);
        program_.set("u_viewport", glm::vec4(owner.width(), owner.height(), 0, 0));
    }
    void set(const char* name, std::uint32_t value) override { program_.set(name, value); }
    void set(const char* name, const glm::vec4& value) override { program_.set(name, value); }
    void set(const char* name, const glm::mat4& value) override { program_.set(name, value); }
    void draw() override {
        owner_.bind_shared();
        program_.use();
        glBindVertexArray(owner_.vertex_array_);
        FragmentChunk chunk;
        std::uint32_t first = 0;
        owner_.trace_.rewind();
        while (owner_.trace_.next(chunk, channels_)) {
            const auto count = static_cast<std::uint32_t>(chunk.size());
            const GlBuffer records(count * sizeof(Fragment), chunk.fragments.data());
            glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, records.id());
            const auto slopes = channel(2, chunk.slopes);
            const auto materials = channel(4, chunk.materials);
            program_.set("u_first_arrival", first);
            glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(count));
            first += count;
        }
        check_gl("drawing the trace's fragments");
    }

 private:
    // What a buffer binding needs for as long as it is drawn from; nothing where the trace has no such
    // channel.
    template <class Value>
    static std::optional<GlBuffer> channel(GLuint binding, const std::vector<Value>& values) {
        if (values.empty()) return std::nullopt;
        std::optional<GlBuffer> buffer(std::in_place, values.size() * sizeof(Value), values.data());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer->id());
        return buffer;
    }
    ReplayedArrivals& owner_;
    GlProgram program_;
    unsigned channels_;
};

std::unique_ptr<ArrivalPass> ReplayedArrivals::pass(const ArrivalText& text) {
    return std::make_unique<Pass>(*this, text);
}

}  // namespace

std::unique_ptr<Arrivals> geometry_arrivals(const Scene& scene, const TraceHeader& header) {
    return std::make_unique<GeometryArrivals>(scene, header);
}
std::unique_ptr<Arrivals> replayed_arrivals(TraceReader& trace) {
    return std::make_unique<ReplayedArrivals>(trace);
}

}  // namespace ropsim
