// A bust modelled from blobs, in decimetres.
#include "capture/scenes/hair_head.h"

#include "capture/scenery/scene_parts.h"

namespace ropsim {
namespace {

std::vector<Blob> torso() {
    std::vector<Blob> blobs = {ellipsoid({0, -3.3f, -0.2f}, {1.25f, 1.5f, 0.72f}, 0.3f)};
    for (float side : {-1.0f, 1.0f}) {
        blobs.push_back(
            limb({side * 0.2f, -1.95f, -0.32f}, {side * 1.42f, -2.3f, -0.3f}, 0.3f, 0.36f, 0.35f));
        blobs.push_back(
            limb({side * 1.48f, -2.35f, -0.3f}, {side * 1.72f, -4.9f, -0.35f}, 0.37f, 0.3f, 0.15f));
        blobs.push_back(ellipsoid({side * 0.52f, -3.3f, 0.28f}, {0.46f, 0.55f, 0.34f}, 0.4f));
    }
    return blobs;
}

std::vector<Blob> head() {
    std::vector<Blob> blobs = {
        ellipsoid(kSkullCentre, kSkullRadii, 0.1f),
        ellipsoid({0, -0.3f, 0.24f}, {0.57f, 0.72f, 0.56f}, 0.25f),
        limb({0, -0.6f, -0.2f}, {0, -2.05f, -0.34f}, 0.39f, 0.42f, 0.2f),
        ellipsoid({0, -0.93f, 0.6f}, {0.15f, 0.14f, 0.14f}, 0.2f),
        limb({-0.3f, 0.14f, 0.66f}, {0.3f, 0.14f, 0.66f}, 0.1f, 0.1f, 0.18f),
    };
    for (float side : {-1.0f, 1.0f}) {
        blobs.push_back(limb({side * 0.4f, -0.5f, 0.02f}, {side * 0.08f, -0.89f, 0.54f}, 0.15f, 0.14f, 0.2f));
        blobs.push_back(ellipsoid({side * 0.37f, -0.26f, 0.54f}, {0.19f, 0.15f, 0.19f}, 0.2f));
        blobs.push_back(ellipsoid({side * 0.77f, -0.14f, -0.05f}, {0.06f, 0.22f, 0.14f}, 0.06f));
    }
    for (float side : {-1.0f, 1.0f}) {
        Blob socket = ellipsoid({side * 0.29f, -0.01f, 0.9f}, {0.2f, 0.11f, 0.15f}, 0.14f);
        socket.carved = true;
        blobs.push_back(socket);
        blobs.push_back(ellipsoid({side * 0.28f, -0.05f, 0.645f}, {0.16f, 0.095f, 0.13f}, 0.02f));
    }
    blobs.push_back(limb({0, 0.1f, 0.75f}, {0, -0.33f, 0.91f}, 0.05f, 0.075f, 0.12f));
    for (float side : {-1.0f, 1.0f}) {
        blobs.push_back(ellipsoid({side * 0.075f, -0.355f, 0.83f}, {0.06f, 0.05f, 0.07f}, 0.05f));
        blobs.push_back(ellipsoid({side * 0.055f, -0.575f, 0.755f}, {0.11f, 0.045f, 0.07f}, 0.04f));
    }
    blobs.push_back(ellipsoid({0, -0.645f, 0.755f}, {0.115f, 0.055f, 0.07f}, 0.06f));
    return blobs;
}

}  // namespace

std::vector<SceneDraw> bust_draws() {
    const glm::vec4 skin(0.68f, 0.45f, 0.34f, 0.0f);
    const glm::vec4 cloth(0.06f, 0.1f, 0.13f, 0.0f);
    const TriangleMesh face = BlobBody(head()).mesh({-1, -2.7f, -1.2f}, {1, 1.3f, 1.2f}, 0.03f);
    const TriangleMesh dress = BlobBody(torso()).mesh({-2.2f, -5.4f, -1.2f}, {2.2f, -1.4f, 1.2f}, 0.06f);
    return {matte_draw("head", face, {{glm::mat4(1.0f), skin}}),
            matte_draw("dress", dress, {{glm::mat4(1.0f), cloth}})};
}

BlobBody bust_obstacle() {
    std::vector<Blob> blobs = torso();
    blobs.push_back(limb({0, -0.6f, -0.2f}, {0, -2.05f, -0.34f}, 0.39f, 0.42f, 0.2f));
    blobs.push_back(ellipsoid(kSkullCentre, kSkullRadii, 0.2f));
    blobs.push_back(ellipsoid({0, -0.5f, 0.6f}, {0.62f, 0.8f, 0.55f}, 0.1f));
    return BlobBody(std::move(blobs));
}

}  // namespace ropsim
