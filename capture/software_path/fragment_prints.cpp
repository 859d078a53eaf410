#include "capture/software_path/fragment_prints.h"

#include "capture/shader_sources.h"
#include "traces/depth_test.h"

#include <bit>
#include <initializer_list>

namespace ropsim {
namespace {

std::size_t pixels_of(const TraceHeader& header) {
    return static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height);
}

class Print {
 public:
    explicit Print(std::uint32_t start) : hash_(start) {}
    void take(std::uint32_t word) {
        hash_ = (hash_ ^ word) * 0x9E3779B1u;
        hash_ ^= hash_ >> 15;
    }
    void take(std::initializer_list<float> values) {
        for (const float value : values) take(std::bit_cast<std::uint32_t>(value));
    }
    std::uint32_t hash() const { return hash_; }

 private:
    std::uint32_t hash_;
};

std::uint32_t print_of(const Fragment& f, const DepthSlope& slope, const Material& m, std::uint32_t visible,
                       std::uint32_t start) {
    Print print(start);
    print.take({f.z, f.r, f.g, f.b, f.a});
    print.take(f.primitive);
    print.take(visible | (static_cast<std::uint32_t>(f.draw) << 16));
    print.take({slope.dx, slope.dy, m.transmission[0], m.transmission[1], m.transmission[2], m.collimation,
                m.eta, m.normal[0], m.normal[1], m.normal[2]});
    return print.hash();
}

}  // namespace

std::vector<std::uint64_t> drawn_fragment_prints(Arrivals& arrivals) {
    std::vector<std::uint64_t> prints(pixels_of(arrivals.header()), 0);
    const GlBuffer buffer(prints.size() * sizeof(std::uint64_t), prints.data());
    const GlTarget nothing(arrivals.width(), arrivals.height(), GL_NONE, false);
    const auto pass =
        arrivals.pass({std::string(shader_source("fragment_prints")), {}, arrivals.header().materials});
    pass->set("u_width", static_cast<std::uint32_t>(arrivals.width()));
    nothing.bind();
    glDisable(GL_DEPTH_TEST);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer.id());
    pass->draw();
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffer.id(), 0, static_cast<GLsizeiptr>(buffer.bytes()), prints.data());
    check_gl("reading fingerprints");
    return prints;
}

std::vector<std::uint64_t> traced_fragment_prints(TraceReader& trace) {
    const TraceHeader& header = trace.header();
    const OpaqueDepthTest test(header);
    std::vector<std::uint64_t> prints(pixels_of(header), 0);
    FragmentChunk chunk;
    trace.rewind();
    while (trace.next(chunk, kAllChannels)) {
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const Fragment& f = chunk.fragments[i];
            const DepthSlope slope = chunk.slopes.empty() ? DepthSlope{} : chunk.slopes[i];
            const Material material = chunk.materials.empty() ? Material{} : chunk.materials[i];
            const std::uint32_t visible = test.visible_samples(f, slope);
            if (visible == 0) continue;
            std::uint64_t& print = prints[f.y * static_cast<std::size_t>(header.width) + f.x];
            const std::uint32_t low =
                static_cast<std::uint32_t>(print) + print_of(f, slope, material, visible, 1);
            const std::uint32_t high =
                static_cast<std::uint32_t>(print >> 32) + print_of(f, slope, material, visible, 2);
            print = std::uint64_t{high} << 32 | low;
        }
    }
    trace.rewind();
    return prints;
}

}  // namespace ropsim
