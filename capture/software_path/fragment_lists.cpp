#include "capture/software_path/fragment_lists.h"

#include "base/error.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cstring>

namespace ropsim {
namespace {

constexpr GLuint kNodes = 0;
constexpr GLuint kHeads = 5;
constexpr std::size_t kMostNodes = std::size_t{1} << 21;
constexpr std::size_t kHeaderBytes = 48;  // the counter, padded to a node: node 0 is no fragment

std::size_t node_capacity(std::size_t wanted) {
    GLint limit = 0;
    glGetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    const std::size_t allowed = static_cast<std::size_t>(limit) / sizeof(ListedFragment) - 1;
    return std::min(wanted == 0 ? kMostNodes : wanted, allowed);
}

std::size_t pixels_of(const Arrivals& arrivals) {
    return static_cast<std::size_t>(arrivals.width()) * static_cast<std::size_t>(arrivals.height());
}

std::string lists_text(const char* main) {
    return std::string(shader_source("fragment_lists")) + std::string(shader_source(main));
}

}  // namespace

GpuFragmentLists::GpuFragmentLists(Arrivals& arrivals, std::size_t nodes)
    : arrivals_(arrivals),
      capacity_(node_capacity(nodes)),
      nodes_(kHeaderBytes + capacity_ * sizeof(ListedFragment), nullptr),
      heads_(pixels_of(arrivals) * sizeof(std::uint32_t), nullptr),
      nothing_(arrivals.width(), arrivals.height(), GL_NONE, false),
      append_(arrivals.pass({lists_text("list_append"), {}, false})),
      order_("order of arrival", std::string(shader_source("arrival")) + lists_text("list_order")) {
    const auto width = static_cast<std::uint32_t>(arrivals.width());
    append_->set("u_width", width);
    append_->set("u_capacity", static_cast<std::uint32_t>(capacity_));
    order_.program().set("u_width", width);
}

void GpuFragmentLists::count_fragments() {
    if (!counts_.empty()) return;
    const auto pass = arrivals_.pass({std::string(shader_source("list_count")), {}, false});
    const RenderTargets target({arrivals_.width(), arrivals_.height()}, {{StoredAs::kFloat32, 2}});
    target.bind();
    target.clear_color(0, glm::vec4(0.0f));
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    pass->draw();
    glDisable(GL_BLEND);
    const std::vector<float> rgba = target.read(0);
    for (std::size_t i = 0; i < rgba.size(); i += 4) {
        counts_.push_back(rgba[i]);
        showing_.push_back(rgba[i + 1]);
    }
}

std::vector<std::uint8_t> GpuFragmentLists::touched_tiles() {
    count_fragments();
    const auto width = static_cast<std::size_t>(arrivals_.width());
    const auto across = static_cast<std::size_t>(tiles_across(arrivals_.width()));
    std::vector<std::uint8_t> tiles(across * static_cast<std::size_t>(tiles_across(arrivals_.height())), 0);
    const auto tile_of = [&](std::size_t i) {
        return i / width / kTileSize * across + i % width / kTileSize;
    };
    for (std::size_t i = 0; i < showing_.size(); ++i)
        if (showing_[i] > 0) tiles[tile_of(i)] = 1;
    std::vector<std::uint8_t> pixels(showing_.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = tiles[tile_of(i)];
    return pixels;
}

std::vector<GpuFragmentLists::Band> GpuFragmentLists::bands() {
    count_fragments();
    const auto width = static_cast<std::size_t>(arrivals_.width());
    std::vector<Band> bands = {{0, 0}};
    double nodes = 0;
    for (int y = 0; y < arrivals_.height(); ++y) {
        double row = 0;
        for (std::size_t x = 0; x < width; ++x)
            row += static_cast<double>(counts_[static_cast<std::size_t>(y) * width + x]);
        if (row > static_cast<double>(capacity_))
            throw UserError("--size",
                            fmt::format("row {} of the image has {:.0f} fragments, and the driver's "
                                        "buffers hold {}; use fewer fragments or a smaller image",
                                        y, row, capacity_));
        if (nodes + row > static_cast<double>(capacity_)) {
            bands.push_back({y, 0});
            nodes = 0;
        }
        nodes += row;
        ++bands.back().rows;
    }
    return bands;
}

// Makes the lists of a rectangle of pixels; leaves them bound and the scissor there.
void GpuFragmentLists::fill(int x, int y, int width, int rows) {
    const std::uint32_t zero = 0;
    glClearNamedBufferData(heads_.id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
    glNamedBufferSubData(nodes_.id(), 0, sizeof zero, &zero);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kNodes, nodes_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kHeads, heads_.id());
    nothing_.bind();
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glEnable(GL_SCISSOR_TEST);
    glScissor(x, y, width, rows);
    append_->set("u_rectangle", glm::vec4(x, y, width, rows));
    append_->draw();
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    std::uint32_t count = 0;
    glGetNamedBufferSubData(nodes_.id(), 0, sizeof count, &count);
    CHECK(count <= capacity_, "{} fragments, {} nodes", count, capacity_);
    order_.draw();
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void GpuFragmentLists::for_bands(const std::function<void()>& body) {
    for (const Band& band : bands()) {
        if (band.rows == 0) continue;
        fill(0, band.y, arrivals_.width(), band.rows);
        body();
    }
    glDisable(GL_SCISSOR_TEST);
}

std::vector<ListedFragment> GpuFragmentLists::at(int x, int y) {
    fill(x, y, 1, 1);
    glDisable(GL_SCISSOR_TEST);
    const auto read = [](const GlBuffer& buffer, std::size_t offset, std::size_t bytes, void* to) {
        glGetNamedBufferSubData(buffer.id(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes),
                                to);
    };
    std::uint32_t count = 0;
    std::uint32_t node = 0;
    read(nodes_, 0, sizeof count, &count);
    const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(arrivals_.width()) +
                              static_cast<std::size_t>(x);
    read(heads_, pixel * sizeof node, sizeof node, &node);
    std::vector<ListedFragment> nodes(count);
    if (count > 0) read(nodes_, kHeaderBytes, count * sizeof(ListedFragment), nodes.data());
    std::vector<ListedFragment> list;
    for (; node != 0 && list.size() < count; node = list.back().next) list.push_back(nodes[node - 1]);
    check_gl("reading a pixel's fragments");
    return list;
}

std::string list_pass_text(const std::vector<const char*>& shaders, StoredAs stored,
                           const std::string& defines) {
    std::vector<const char*> all = {"fragment_lists"};
    all.insert(all.end(), shaders.begin(), shaders.end());
    return resolve_text(all, stored, defines);
}

Image image_from_lists(Arrivals& arrivals, const std::vector<const char*>& shaders, StoredAs stored,
                       const std::string& defines, std::uint64_t seed) {
    GpuFragmentLists lists(arrivals);
    const ScreenPass pass(shaders.back(), list_pass_text(shaders, stored, defines));
    pass.program().set("u_width", static_cast<std::uint32_t>(arrivals.width()));
    pass.program().set("u_seed_low", static_cast<std::uint32_t>(seed));
    pass.program().set("u_seed_high", static_cast<std::uint32_t>(seed >> 32));
    arrivals.set_shared(pass.program());
    const RenderTargets target({arrivals.width(), arrivals.height()}, {{StoredAs::kFloat32, 4}});
    lists.for_bands([&] {
        target.bind();
        arrivals.bind_shared();
        pass.draw();
    });
    return image_of(arrivals.width(), arrivals.height(), target.read(0));
}

}  // namespace ropsim
