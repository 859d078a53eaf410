// Splat files: what is read, and that no damage goes unnoticed or does harm.
#include "capture/files/splat_file.h"

#include "base/error.h"
#include "base/random.h"
#include "tests/capture/splat_ply.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::PlyProperty;
using testing::splat_ply;

// The message of the UserError, "" if the bytes are accepted.
std::string fault(const std::vector<std::uint8_t>& bytes) {
    try {
        parse_splats(bytes, "a.ply");
    } catch (const UserError& error) {
        EXPECT_EQ(error.where(), "a.ply");
        std::string what = error.what();
        EXPECT_EQ(what.find('\n'), std::string::npos) << what;
        return what;
    }
    return "";
}

// Two splats with the properties that the reference code writes, third-degree harmonics.
std::vector<PlyProperty> reference_properties(int rest = 45) {
    std::vector<PlyProperty> properties;
    const auto add = [&](const std::string& name, double first, double second) {
        properties.push_back({"float", name, {first, second}});
    };
    add("x", 1, -4);
    add("y", 2, -5);
    add("z", 3, -6);
    for (const char* name : {"nx", "ny", "nz"}) add(name, 0, 0);
    for (int i = 0; i < 3; ++i) add("f_dc_" + std::to_string(i), 0.1 * i, -0.1 * i);
    for (int i = 0; i < rest; ++i) add("f_rest_" + std::to_string(i), 100 + i, 200 + i);
    add("opacity", 0, std::log(3.0));
    for (int i = 0; i < 3; ++i) add("scale_" + std::to_string(i), std::log(0.5 + i), -1);
    for (int i = 0; i < 4; ++i) add("rot_" + std::to_string(i), i == 0 ? 3 : 0, i == 2 ? -0.5 : 0);
    return properties;
}

TEST(SplatFileTest, ReferenceLayoutIsReadAndActivated) {
    const SplatFile splats = parse_splats(splat_ply(reference_properties()), "a.ply");
    ASSERT_EQ(splats.size(), 2u);
    EXPECT_EQ(splats.degree, 3);
    EXPECT_EQ(splats.positions[1], glm::vec3(-4, -5, -6));
    EXPECT_NEAR(splats.scales[0].x, 0.5, 1e-6);
    EXPECT_NEAR(splats.scales[0].z, 2.5, 1e-6);
    EXPECT_NEAR(splats.scales[1].y, std::exp(-1.0), 1e-6);
    EXPECT_FLOAT_EQ(splats.opacities[0], 0.5f);
    EXPECT_NEAR(splats.opacities[1], 0.75, 1e-6);
    EXPECT_EQ(splats.rotations[0], glm::quat(1, 0, 0, 0));
    EXPECT_EQ(splats.rotations[1], glm::quat(0, 0, -1, 0));
    // Red's fifteen come first, then green's, then blue's.
    EXPECT_FLOAT_EQ(splats.harmonics[0].y, 0.1f);
    EXPECT_EQ(splats.harmonics[1], glm::vec3(100, 115, 130));
    EXPECT_EQ(splats.harmonics[15], glm::vec3(114, 129, 144));
    EXPECT_EQ(splats.harmonics[16 + 15], glm::vec3(214, 229, 244));
}

TEST(SplatFileTest, RotationsOfAnyLengthBecomeUnitQuaternions) {
    for (const double scale : {1e-44, 1e-38, 1e-20, 1.0, 1e20, 2e38}) {
        std::vector<PlyProperty> properties = reference_properties(0);
        for (PlyProperty& property : properties) {
            if (property.name == "rot_1") property.values[0] = scale;
            if (property.name == "rot_0") property.values[0] = -scale;
        }
        const SplatFile splats = parse_splats(splat_ply(properties), "a.ply");
        EXPECT_NEAR(splats.rotations[0].w, -std::sqrt(0.5), 1e-6) << scale;
        EXPECT_NEAR(splats.rotations[0].x, std::sqrt(0.5), 1e-6) << scale;
    }
}

TEST(SplatFileTest, AnyOrderAndFurtherPropertiesAndDoublesGiveTheSame) {
    std::vector<PlyProperty> properties = reference_properties(9);
    const SplatFile plain = parse_splats(splat_ply(properties), "a.ply");
    EXPECT_EQ(plain.degree, 1);
    std::reverse(properties.begin(), properties.end());
    properties.insert(properties.begin() + 3, {"uchar", "segment", {7, 8}});
    properties.insert(properties.begin() + 9, {"int", "id", {70000, 8}});
    for (PlyProperty& property : properties)
        if (property.name == "x" || property.name == "opacity") property.type = "double";
    const SplatFile other = parse_splats(splat_ply(properties), "a.ply");
    EXPECT_EQ(other.positions, plain.positions);
    EXPECT_EQ(other.scales, plain.scales);
    EXPECT_EQ(other.rotations, plain.rotations);
    EXPECT_EQ(other.opacities, plain.opacities);
    EXPECT_EQ(other.harmonics, plain.harmonics);
}

TEST(SplatFileTest, EveryHarmonicDegreeIsTold) {
    for (const auto& [rest, degree] : {std::pair(0, 0), std::pair(9, 1), std::pair(24, 2), std::pair(45, 3)})
        EXPECT_EQ(parse_splats(splat_ply(reference_properties(rest)), "a.ply").degree, degree);
    EXPECT_THAT(fault(splat_ply(reference_properties(12))), ::testing::HasSubstr("12 properties f_rest_*"));
    EXPECT_THAT(fault(splat_ply(reference_properties(48))), ::testing::HasSubstr("48 properties f_rest_*"));
}

TEST(SplatFileTest, ValuesThatCannotBeAreRefusedWithTheirPlace) {
    const auto with = [](const std::string& name, double value) {
        std::vector<PlyProperty> properties = reference_properties(0);
        for (PlyProperty& property : properties)
            if (property.name == name) property.values[1] = value;
        return fault(splat_ply(properties));
    };
    EXPECT_THAT(with("y", std::nan("")), ::testing::HasSubstr("splat 1 "));
    EXPECT_THAT(with("y", std::nan("")), ::testing::HasSubstr("y is nan"));
    EXPECT_THAT(with("f_dc_2", std::numeric_limits<double>::infinity()),
                ::testing::HasSubstr("f_dc_2 is inf"));
    EXPECT_THAT(with("opacity", std::nan("")), ::testing::HasSubstr("opacity"));
    EXPECT_THAT(with("scale_1", 100), ::testing::HasSubstr("exponential of scale_1"));
    EXPECT_THAT(with("rot_2", 0), ::testing::HasSubstr("rot_0..3"));
}

TEST(SplatFileTest, HeadersThatAreNotSplatsAreRefused) {
    const auto header = [](const std::string& text) {
        return fault(std::vector<std::uint8_t>(text.begin(), text.end()));
    };
    EXPECT_THAT(header(""), ::testing::HasSubstr("line 1"));
    EXPECT_THAT(header("plx\n"), ::testing::HasSubstr("not a PLY"));
    EXPECT_THAT(header("ply\nformat ascii 1.0\n"), ::testing::HasSubstr("line 2"));
    EXPECT_THAT(header("ply\nformat binary_little_endian 1.0\nelement face 3\n"),
                ::testing::HasSubstr("'vertex'"));
    EXPECT_THAT(header("ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty list uchar int i\n"),
                ::testing::HasSubstr("line 4"));
    EXPECT_THAT(
        header("ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nend_header\n"),
        ::testing::HasSubstr("has no property"));
    EXPECT_THAT(header("ply\nelement vertex 1\nproperty float x\nproperty float x\n"),
                ::testing::HasSubstr("before"));
    EXPECT_THAT(header("ply\nelement vertex -1\n"), ::testing::HasSubstr("no number"));
    // A count that no memory could hold.
    std::vector<std::uint8_t> bytes = splat_ply(reference_properties(0));
    const std::string count = "element vertex 2";
    const auto at = std::search(bytes.begin(), bytes.end(), count.begin(), count.end());
    const std::string more = "element vertex 18446744073709551615";
    bytes.insert(bytes.erase(at, at + static_cast<std::ptrdiff_t>(count.size())), more.begin(), more.end());
    EXPECT_THAT(fault(bytes), ::testing::HasSubstr("cut short"));
}

TEST(SplatFileTest, CutAnywhereItIsRefused) {
    const std::vector<std::uint8_t> whole = splat_ply(reference_properties());
    ASSERT_EQ(fault(whole), "");
    for (std::size_t percent = 0; percent < 100; ++percent) {
        const std::size_t length = whole.size() * percent / 100;
        EXPECT_NE(fault({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)}), "") << percent;
    }
    std::vector<std::uint8_t> longer = whole;
    longer.push_back(0);
    EXPECT_THAT(fault(longer), ::testing::HasSubstr("1 bytes follow"));
}

TEST(SplatFileTest, FlippedBitsAreReadOrRefusedButDoNoHarm) {
    const std::vector<std::uint8_t> whole = splat_ply(reference_properties());
    int refused = 0;
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
        std::vector<std::uint8_t> bytes = whole;
        bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
        try {
            const SplatFile splats = parse_splats(bytes, "a.ply");
            ASSERT_LE(splats.size(), 2u);
            for (const glm::quat& rotation : splats.rotations) EXPECT_NEAR(glm::length(rotation), 1, 1e-5);
        } catch (const UserError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 100);
}

TEST(SplatFileTest, SplatFilesAreToldFromMeshes) {
    const std::string splats = ::testing::TempDir() + "/told_splats.ply";
    testing::write_bytes(splats, splat_ply(reference_properties(0)));
    EXPECT_TRUE(is_splat_ply(splats));
    EXPECT_EQ(load_splats(splats).size(), 2u);
    const std::string mesh = ::testing::TempDir() + "/told_mesh.ply";
    std::ofstream(mesh) << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                           "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                           "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    EXPECT_FALSE(is_splat_ply(mesh));
    EXPECT_FALSE(is_splat_ply("/nowhere/at/all.ply"));
    EXPECT_THROW(load_splats("/nowhere/at/all.ply"), UserError);
    EXPECT_THROW(load_splats(::testing::TempDir()), UserError);
}

}  // namespace
}  // namespace ropsim
