// Damaged mesh files: an error about the file, or a sound mesh, never a crash.
#include "base/error.h"
#include "capture/geometry/mesh.h"
#include "tests/capture/mesh_samples.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

namespace ropsim {
namespace {

struct Format {
    const char* name;
    std::string (*make)();
};

class MeshDamageTest : public ::testing::TestWithParam<Format> {
 protected:
    // Whether the file loads; what loads must be sound, what does not must be a UserError about the file.
    bool loads(const std::string& content, const std::string& what) const {
        const std::string path = ::testing::TempDir() + "/damaged." + GetParam().name;
        std::ofstream(path, std::ios::binary) << content;
        try {
            const TriangleMesh mesh = load_mesh(path);
            EXPECT_EQ(mesh.normals.size(), mesh.positions.size()) << what;
            EXPECT_GT(mesh.triangles(), 0u) << what;
            for (std::uint32_t index : mesh.indices) EXPECT_LT(index, mesh.positions.size()) << what;
            for (std::uint32_t index : mesh.indices)
                for (int axis = 0; axis < 3; ++axis)
                    EXPECT_LE(std::abs(mesh.positions[index][axis]), 0.5001f) << what;
            return true;
        } catch (const UserError& error) {
            EXPECT_EQ(error.where(), path) << what;
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos)
                << what << ": " << error.what();
            return false;
        }
    }
};

TEST_P(MeshDamageTest, WholeFilesLoad) {
    EXPECT_TRUE(loads(GetParam().make(), "whole"));
}

TEST_P(MeshDamageTest, FilesCutShortAnywhere) {
    const std::string whole = GetParam().make();
    int failed = 0;
    for (std::size_t percent = 0; percent < 100; ++percent)
        failed += loads(whole.substr(0, whole.size() * percent / 100), fmt::format("{}%", percent)) ? 0 : 1;
    // Text that ends early may still be a mesh, of fewer faces.
    EXPECT_GT(failed, 25);
}

TEST_P(MeshDamageTest, SingleBitsFlipped) {
    const std::string whole = GetParam().make();
    std::mt19937 random(7);
    for (int i = 0; i < 150; ++i) {
        std::string damaged = whole;
        const std::size_t bit = random() % (8 * whole.size());
        damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
        loads(damaged, fmt::format("bit {}", bit));
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshDamageTest,
                         ::testing::Values(Format{"obj", testing::obj_file}, Format{"ply", testing::ply_file},
                                           Format{"stl", testing::stl_file},
                                           Format{"3ds", testing::three_ds_file}),
                         [](const auto& format) { return std::string(format.param.name); });

TEST(MeshFileTest, OnlyRegularFilesAreOpened) {
    const std::string path = ::testing::TempDir() + "/pipe.obj";
    ::unlink(path.c_str());
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    EXPECT_THROW(load_mesh(path), UserError);  // opening it would wait for a writer for ever
    EXPECT_THROW(load_mesh(::testing::TempDir()), UserError);
}

}  // namespace
}  // namespace ropsim
