// Fuzzes the guarded reading of meshes: the first byte picks the file's ending, which picks Assimp's reader.
#include "capture/geometry/mesh.h"
#include "tests/fuzz/fuzz_input.h"

#include <fstream>

namespace {

void check(const ropsim::TriangleMesh& mesh) {
    CHECK(mesh.triangles() > 0 && mesh.normals.size() == mesh.positions.size());
    for (std::uint32_t index : mesh.indices) CHECK(index < mesh.positions.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ropsim;
    constexpr const char* kEndings[] = {"obj", "ply", "stl", "3ds", "gltf"};
    if (size == 0) return 0;
    const std::string path =
        fuzz::scratch_path(std::string("mesh.") + kEndings[data[0] % std::size(kEndings)]);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(data + 1), static_cast<std::streamsize>(size - 1));
    fuzz::accepted([&] { check(load_mesh(path)); });
    return 0;
}
