// Packs splats for the vertex shader: covariance, colour, opacity.
#include "capture/scenery/splat_draw.h"

#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

constexpr std::size_t kFloatsASplat = 13;                   // position, covariance, colour, opacity
constexpr std::size_t kSplatsADraw = std::size_t{1} << 21;  // 104 MiB, below every driver's limit
constexpr std::size_t kBatch = 8192;

float linear(float display) {
    const float c = std::max(display, 0.0f);
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

void pack(const SplatFile& splats, std::size_t i, glm::vec3 eye, float* out) {
    const glm::mat3 axes =
        glm::mat3_cast(splats.rotations[i]) *
        glm::mat3(splats.scales[i].x, 0, 0, 0, splats.scales[i].y, 0, 0, 0, splats.scales[i].z);
    const glm::mat3 covariance = axes * glm::transpose(axes);
    const glm::vec3 position = splats.positions[i];
    const glm::vec3 away = position - eye;
    const float distance = glm::length(away);
    const glm::vec3 direction = distance > 0 ? away / distance : glm::vec3(0, 0, 1);
    const glm::vec3 color =
        splat_color(&splats.harmonics[i * splats.harmonics_a_splat()], splats.degree, direction);
    const float values[kFloatsASplat] = {
        position.x,       position.y,       position.z,         covariance[0][0], covariance[1][0],
        covariance[2][0], covariance[1][1], covariance[2][1],   covariance[2][2], color.r,
        color.g,          color.b,          splats.opacities[i]};
    std::copy(std::begin(values), std::end(values), out);
}

}  // namespace

glm::vec3 splat_color(const glm::vec3* harmonics, int degree, glm::vec3 direction) {
    const float x = direction.x;
    const float y = direction.y;
    const float z = direction.z;
    // Real spherical harmonics with the reference code's signs.
    const float basis[16] = {0.28209479f,
                             -0.48860251f * y,
                             0.48860251f * z,
                             -0.48860251f * x,
                             1.09254843f * x * y,
                             -1.09254843f * y * z,
                             0.31539157f * (2 * z * z - x * x - y * y),
                             -1.09254843f * x * z,
                             0.54627421f * (x * x - y * y),
                             -0.59004359f * y * (3 * x * x - y * y),
                             2.89061144f * x * y * z,
                             -0.45704579f * y * (4 * z * z - x * x - y * y),
                             0.37317633f * z * (2 * z * z - 3 * x * x - 3 * y * y),
                             -0.45704579f * x * (4 * z * z - x * x - y * y),
                             1.44530572f * z * (x * x - y * y),
                             -0.59004359f * x * (x * x - 3 * y * y)};
    glm::vec3 sum(0.5f);
    for (int i = 0; i < (degree + 1) * (degree + 1); ++i) sum += basis[i] * harmonics[i];
    return {linear(sum.r), linear(sum.g), linear(sum.b)};
}

std::vector<SceneDraw> splat_draws(const std::string& name, const SplatFile& splats, glm::vec3 eye) {
    std::vector<SceneDraw> draws;
    for (std::size_t first = 0; first < splats.size(); first += kSplatsADraw) {
        const std::size_t count = std::min(kSplatsADraw, splats.size() - first);
        SceneDraw draw;
        draw.state.name = first == 0 ? name : fmt::format("{} {}", name, first / kSplatsADraw + 1);
        draw.vertex = shader_source("splat_vertex");
        draw.shading = shader_source("splat_shading");
        draw.primitives = static_cast<std::uint32_t>(2 * count);
        SceneBuffer buffer{1, std::vector<float>(count * kFloatsASplat)};
        draw.indices.resize(6 * count);
        const auto batches = static_cast<int>((count + kBatch - 1) / kBatch);
        parallel_for(default_threads(), batches, [&](int batch) {
            const std::size_t begin = static_cast<std::size_t>(batch) * kBatch;
            for (std::size_t i = begin; i < std::min(begin + kBatch, count); ++i) {
                pack(splats, first + i, eye, &buffer.values[i * kFloatsASplat]);
                const auto v = static_cast<std::uint32_t>(4 * i);
                const std::uint32_t corners[6] = {v, v + 1, v + 2, v + 1, v + 3, v + 2};
                std::copy(std::begin(corners), std::end(corners), &draw.indices[6 * i]);
            }
        });
        draw.buffers = {std::move(buffer)};
        draws.push_back(std::move(draw));
    }
    return draws;
}

SplatFile thinned_or_cloned(const SplatFile& source, double count, std::uint64_t seed) {
    SplatFile result;
    result.degree = source.degree;
    const std::size_t terms = source.harmonics_a_splat();
    const auto whole = static_cast<std::uint32_t>(count);
    const auto part = static_cast<float>(count - whole);
    for (std::size_t i = 0; i < source.size(); ++i) {
        const std::uint64_t key = mix64(seed ^ (0x53706C74ull << 32) ^ i);
        const std::uint32_t copies = whole + (random_unit(key, 0) < part ? 1 : 0);
        for (std::uint32_t k = 0; k < copies; ++k) {
            glm::vec3 aside(0);
            for (std::uint32_t axis = 0; axis < 3 && k > 0; ++axis)
                aside[static_cast<int>(axis)] = random_unit(key, 3 * k + axis) - 0.5f;
            result.positions.push_back(source.positions[i] +
                                       source.rotations[i] * (source.scales[i] * aside));
            result.scales.push_back(source.scales[i]);
            result.rotations.push_back(source.rotations[i]);
            result.opacities.push_back(source.opacities[i]);
            result.harmonics.insert(result.harmonics.end(),
                                    source.harmonics.begin() + static_cast<std::ptrdiff_t>(i * terms),
                                    source.harmonics.begin() + static_cast<std::ptrdiff_t>((i + 1) * terms));
        }
    }
    return result;
}

}  // namespace ropsim
