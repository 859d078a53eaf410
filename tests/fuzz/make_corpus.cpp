// Writes the seed inputs of the fuzz targets: make_fuzz_corpus tests/fuzz/corpus. The same program writes the
// same files; findings that stand beside them are left alone.
#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/capture/mesh_samples.h"
#include "traces/generators.h"
#include "traces/interchange/csv.h"
#include "traces/interchange/deep_exr.h"

#include <cstdio>
#include <filesystem>
#include <string>

namespace ropsim {
namespace {

using testing::put;

struct TraceSeed {
    const char* name;
    RandomFragments options;
    bool non_finite = false;
};

// Every feature of the format at least once, in a few hundred bytes each.
std::vector<TraceSeed> trace_seeds() {
    RandomFragments plain;
    plain.width = 17;
    plain.height = 9;
    plain.count = 40;
    RandomFragments rich = plain;
    rich.samples = 4;
    rich.partial_coverage = rich.opaque = rich.slopes = rich.materials = true;
    rich.draws = 3;
    rich.color_storage = ColorStorage::kFloat16;
    RandomFragments ties = plain;
    ties.count = 120;
    ties.depth_levels = 3;
    ties.order = RandomFragments::Order::kBackToFront;
    RandomFragments empty = plain;
    empty.count = 0;
    return {{"plain", plain}, {"rich", rich}, {"ties", ties}, {"empty", empty}, {"non_finite", plain, true}};
}

void write_trace_seed(const std::string& path, const TraceSeed& seed) {
    TraceHeader header = random_header(seed.options);
    header.non_finite = seed.non_finite;
    constexpr TraceLayoutOptions kManyBlocks{100, 8};
    TraceWriter writer(path, header, kManyBlocks);
    writer.append(random_chunk(seed.options));
    writer.finish();
}

std::string hair_seed(bool arrays) {
    std::string bytes = "HAIR";
    put(bytes, std::uint32_t{2});  // strands
    put(bytes, std::uint32_t{5});  // points
    put(bytes, std::uint32_t{arrays ? 31u : 2u});
    put(bytes, std::uint32_t{1});                                           // segments a strand
    for (float value : {0.5f, 0.25f, 0.1f, 0.2f, 0.3f}) put(bytes, value);  // thickness, transparency, colour
    bytes.resize(128, ' ');
    if (!arrays) bytes[8] = 4;  // two points a strand
    if (arrays)
        for (std::uint16_t segments : {1, 2}) put(bytes, segments);
    const int points = arrays ? 5 : 4;
    for (int i = 0; i < 3 * points; ++i) put(bytes, 0.25f * static_cast<float>(i));
    if (arrays)
        for (int i = 0; i < 5 * points; ++i) put(bytes, 0.5f);  // thickness, transparency, colour
    return bytes;
}

std::string splat_seed(int rest) {
    std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n";
    std::vector<std::string> names = {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2"};
    for (int i = 0; i < rest; ++i) names.push_back(fmt::format("f_rest_{}", i));
    for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        names.emplace_back(name);
    for (const std::string& name : names) bytes += fmt::format("property float {}\n", name);
    bytes += "end_header\n";
    for (std::size_t i = 0; i < 3 * names.size(); ++i) put(bytes, 0.1f * static_cast<float>(i % 7 + 1));
    return bytes;
}

void write_all(const std::string& folder) {
    for (const char* target : {"trace", "csv", "deep_exr", "hair", "splat", "mesh"})
        std::filesystem::create_directories(folder + "/" + target);
    for (const TraceSeed& seed : trace_seeds()) {
        const std::string trace = fmt::format("{}/trace/{}", folder, seed.name);
        write_trace_seed(trace, seed);
        export_csv(trace, fmt::format("{}/csv/{}", folder, seed.name));
        export_deep_exr(trace, fmt::format("{}/deep_exr/{}", folder, seed.name));
    }
    write_file(folder + "/hair/arrays", hair_seed(true));
    write_file(folder + "/hair/defaults", hair_seed(false));
    write_file(folder + "/splat/degree_0", splat_seed(0));
    write_file(folder + "/splat/degree_1", splat_seed(9));
    // The first byte picks the file's ending (mesh_fuzz.cpp).
    const std::string meshes[] = {testing::obj_file(), testing::ply_file(), testing::stl_file(),
                                  testing::three_ds_file()};
    const char* names[] = {"obj", "ply", "stl", "3ds"};
    for (std::size_t i = 0; i < std::size(meshes); ++i)
        write_file(fmt::format("{}/mesh/{}", folder, names[i]), static_cast<char>(i) + meshes[i]);
}

}  // namespace
}  // namespace ropsim

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_fuzz_corpus FOLDER\n");
        return 1;
    }
    try {
        ropsim::write_all(argv[1]);
    } catch (const ropsim::UserError& error) {
        std::fprintf(stderr, "%s: %s\n", error.where().c_str(), error.what());
        return 1;
    }
    return 0;
}
