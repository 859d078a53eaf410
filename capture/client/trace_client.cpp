// The C interface over TraceWriter: gathers the header, opens the file at the first append, turns faults into
// text.
#include "base/error.h"
#include "capture/client/ropsim_trace_client.h"
#include "capture/client/trace_in_progress.h"
#include "traces/trace.h"

#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

using ropsim::Fragment;
using ropsim::UserError;

namespace {

constexpr int kMaxSize = 16384;
constexpr int kMaxSamples = 16;
static_assert(sizeof(RopsimFragment) == sizeof(Fragment));

ropsim::Camera camera_of(const RopsimCamera& camera) {
    ropsim::Camera result;
    result.view = glm::make_mat4(camera.view);
    result.projection = glm::make_mat4(camera.projection);
    result.near_plane = camera.near_plane;
    result.far_plane = camera.far_plane;
    result.fovy_degrees = camera.fovy_degrees;
    result.metres_per_unit = camera.metres_per_unit == 0 ? 1.0f : camera.metres_per_unit;
    return result;
}

ropsim::ShaderCost cost_of(const RopsimShaderCost& cost) {
    return {cost.alu_instructions, cost.texture_fetches, cost.texture_bytes};
}

// Runs `work`; no exception leaves it.
template <typename Work>
int guarded(RopsimTrace* trace, Work work) {
    if (trace == nullptr || !trace->error.empty()) return 1;
    try {
        if (trace->finished) trace->fail("the trace is finished; create another");
        work();
        return 0;
    } catch (const UserError& error) {
        trace->error = fmt::format("{}: {}", error.where(), error.what());
    } catch (const std::exception& error) {
        trace->error = fmt::format("{}: {}", trace->path, error.what());
    }
    trace->writer.reset();  // abandons the file
    return 1;
}

void expect(const RopsimTrace& trace, const void* pointer, const char* name) {
    if (pointer == nullptr) trace.fail(fmt::format("{} is null", name));
}

int set_view(RopsimTrace* trace, const RopsimCamera* given,
             std::optional<ropsim::Camera> ropsim::TraceHeader::*member, const char* name) {
    return guarded(trace, [&] {
        trace->expect_not_begun(name);
        expect(*trace, given, name);
        trace->header.*member = camera_of(*given);
    });
}

}  // namespace

extern "C" {

RopsimTrace* ropsim_trace_create(const char* path, const RopsimTraceInfo* info) {
    try {
        auto trace = std::make_unique<RopsimTrace>();
        trace->path = path == nullptr ? "" : path;
        if (path == nullptr || info == nullptr) {
            trace->error = "ropsim_trace_create: path or info is null";
            return trace.release();
        }
        ropsim::TraceHeader& header = trace->header;
        header.width = info->width;
        header.height = info->height;
        header.samples = info->samples == 0 ? 1 : info->samples;
        header.background = {info->background[0], info->background[1], info->background[2]};
        header.color_storage =
            info->half_colors != 0 ? ropsim::ColorStorage::kFloat16 : ropsim::ColorStorage::kFloat32;
        header.scene = info->scene == nullptr ? "" : info->scene;
        trace->bottom_up = info->bottom_up != 0;
        if (header.width < 1 || header.height < 1 || header.width > kMaxSize || header.height > kMaxSize ||
            header.samples < 1 || header.samples > kMaxSamples ||
            (header.samples & (header.samples - 1)) != 0) {
            trace->error =
                fmt::format("{}: {}x{} pixels of {} samples; sizes are 1 to 16384, samples 1, 2, 4, 8 or 16",
                            trace->path, header.width, header.height, header.samples);
        }
        return trace.release();
    } catch (const std::exception&) {
        return nullptr;
    }
}

int ropsim_trace_set_camera(RopsimTrace* trace, const RopsimCamera* camera) {
    return set_view(trace, camera, &ropsim::TraceHeader::camera, "camera");
}

int ropsim_trace_set_light(RopsimTrace* trace, const RopsimCamera* light) {
    return set_view(trace, light, &ropsim::TraceHeader::light, "light");
}

int ropsim_trace_set_opaque(RopsimTrace* trace, const float* rgb, const float* depth) {
    return guarded(trace, [&] {
        trace->expect_not_begun("opaque layer");
        expect(*trace, rgb, "rgb");
        expect(*trace, depth, "depth");
        trace->set_opaque(rgb, depth);
    });
}

int ropsim_trace_add_draw(RopsimTrace* trace, const RopsimDraw* given, uint32_t* number) {
    return guarded(trace, [&] {
        trace->expect_not_begun("draws");
        expect(*trace, given, "draw");
        const auto blend = static_cast<unsigned>(given->blend);
        const auto cull = static_cast<unsigned>(given->cull);
        if (blend > kRopsimMultiply || cull > kRopsimCullFront)
            trace->fail("a draw's blend or cull is none of its enumeration");
        const auto index = static_cast<std::uint32_t>(trace->header.draws.size());
        ropsim::Draw draw;
        draw.name = given->name == nullptr ? fmt::format("draw {}", index) : given->name;
        draw.object_id = index;
        draw.depth_test = given->depth_test != 0;
        draw.depth_write = given->depth_write != 0;
        draw.blend = static_cast<ropsim::BlendMode>(blend);
        draw.cull = static_cast<ropsim::CullMode>(cull);
        if (given->cost_source != nullptr) {
            draw.full = cost_of(given->full);
            draw.alpha = cost_of(given->alpha);
            draw.cost_source = given->cost_source;
        }
        trace->header.draws.push_back(std::move(draw));
        if (number != nullptr) *number = index;
    });
}

uint64_t ropsim_records_lost(const void* buffer, size_t bytes) {
    const auto [arrived, present] = ropsim::client::record_counts(buffer, bytes);
    return arrived - present;
}

int ropsim_trace_append_records(RopsimTrace* trace, const void* buffer, size_t bytes) {
    return guarded(trace, [&] { trace->append_records(buffer, bytes); });
}

int ropsim_trace_append_fragments(RopsimTrace* trace, const RopsimFragment* fragments, size_t count) {
    return guarded(trace, [&] {
        if (count > 0) expect(*trace, fragments, "fragments");
        trace->append_fragments(fragments, count);
    });
}

int ropsim_trace_finish(RopsimTrace* trace) {
    return guarded(trace, [&] {
        trace->begin();
        trace->writer->finish();
        trace->finished = true;
        trace->writer.reset();
    });
}

const char* ropsim_trace_error(const RopsimTrace* trace) {
    return trace == nullptr ? "no memory for a trace" : trace->error.c_str();
}

void ropsim_trace_free(RopsimTrace* trace) {
    delete trace;
}

}  // extern "C"
