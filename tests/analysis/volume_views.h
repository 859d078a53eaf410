// What the tests of marched media share: a small view of a wall, the medium's fragments pixel by pixel.
#pragma once

#include "analysis/volume_trace.h"
#include "base/error.h"
#include "rop/reference.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <cmath>
#include <limits>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace ropsim {

inline constexpr float kNear = 0.5f, kFar = 40;

inline TraceHeader header_with(const glm::mat4& projection, int width = 20, int height = 12) {
    TraceHeader header;
    header.width = width;
    header.height = height;
    header.background = {0.25f, 0.5f, 0.75f};
    header.draws.resize(1);
    header.camera.emplace();
    header.camera->projection = projection;
    header.camera->near_plane = kNear;
    header.camera->far_plane = kFar;
    return header;
}
// From the origin along -z.
inline TraceHeader perspective_view(int width = 20, int height = 12) {
    return header_with(
        glm::perspective(0.7f, static_cast<float>(width) / static_cast<float>(height), kNear, kFar), width,
        height);
}
inline TraceHeader orthographic_view(int width = 20, int height = 12) {
    return header_with(glm::ortho(-2.0f, 2.0f, -1.0f, 1.0f, kNear, kFar), width, height);
}

// Window depth of a camera-space point on the axis.
inline float window_depth(const TraceHeader& header, double z) {
    const glm::dvec4 clip = glm::dmat4(header.camera->projection) * glm::dvec4(0, 0, z, 1);
    return static_cast<float>((clip.z / clip.w + 1) / 2);
}

// A wall across the axis at `distance`, behind the left half of the picture; nothing behind the right one.
inline void put_wall(TraceHeader& header, double distance) {
    header.opaque.emplace();
    const float depth = window_depth(header, -distance);
    for (int y = 0; y < header.height; ++y)
        for (int x = 0; x < header.width; ++x)
            for (int m = 0; m < header.samples; ++m) {
                header.opaque->rgb.insert(header.opaque->rgb.end(), {1, 0.5f, 0});
                header.opaque->depth.push_back(2 * x < header.width ? depth
                                                                    : std::numeric_limits<float>::infinity());
            }
}

class VolumeTest : public ScratchTest {
 protected:
    // The trace of the header's view, without fragments, with a medium.
    VolumeSummary march(const TraceHeader& header, const VolumeOptions& options,
                        const std::string& out = "out") const {
        write_trace(path("in"), header, {});
        return add_volume(path("in"), path(out), options);
    }
    std::vector<std::vector<Fragment>> by_pixel(const std::string& name = "out") const {
        TraceReader reader(path(name));
        const auto width = static_cast<std::size_t>(reader.header().width);
        std::vector<std::vector<Fragment>> pixels(width * static_cast<std::size_t>(reader.header().height));
        FragmentChunk chunk;
        while (reader.next(chunk))
            for (const Fragment& f : chunk.fragments) pixels[f.y * width + f.x].push_back(f);
        return pixels;
    }
    Image reference(const std::string& name = "out") const {
        TraceReader reader(path(name));
        return reference_image(reader, 2);
    }
};

inline double transmittance(const std::vector<Fragment>& fragments) {
    double product = 1;
    for (const Fragment& f : fragments) product *= 1 - static_cast<double>(f.a);
    return product;
}

// From the plane at depth 1 along the axis to a pixel's centre, and on the ray's slant: 1 / cos.
inline double slant(const TraceHeader& perspective, int x, int y) {
    const double tangent = std::tan(static_cast<double>(0.7f) / 2),
                 aspect = static_cast<double>(perspective.width) / perspective.height;
    const double u = (2 * (x + 0.5) / perspective.width - 1) * tangent * aspect;
    const double v = (2 * (y + 0.5) / perspective.height - 1) * tangent;
    return std::sqrt(1 + u * u + v * v);
}

}  // namespace ropsim
