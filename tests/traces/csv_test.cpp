// CSV fragments: what is read from them, lossless export, and errors with their places.
#include "traces/interchange/csv.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/trace_conversion.h"
#include "traces/generators.h"
#include "traces/interchange/csv_values.h"
#include "traces/stress_traces.h"

#include <bit>
#include <cstring>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Csv : public ScratchTest {
 protected:
    std::vector<Fragment> import(const std::string& text) {
        write_file(path("f.csv"), text);
        import_csv(path("f.csv"), path("t"));
        return read_fragments(path("t"));
    }
    // "line:... message" of the UserError that importing `text` ends in.
    std::string fault(const std::string& text) {
        try {
            import(text);
        } catch (const UserError& error) {
            const std::string file = path("f.csv");
            EXPECT_EQ(error.where().substr(0, file.size()), file);
            return error.where().substr(file.size()) + ": " + error.what();
        }
        return "(accepted)";
    }
};

TEST_F(Csv, ReadsStraightColourAndDefaults) {
    const std::vector<Fragment> f =
        import("# size 20x10\n# samples 4\nx,y,z,r,g,b,a\n3,4,0.25,0.5,1,2,0.5\n\n19,9,1,0,0,0,0\n");
    ASSERT_EQ(f.size(), 2u);
    EXPECT_EQ(f[0].x, 3);
    EXPECT_EQ(f[0].y, 4);
    EXPECT_EQ(f[0].z, 0.25f);
    EXPECT_EQ(f[0].r, 0.25f);  // premultiplied
    EXPECT_EQ(f[0].g, 0.5f);
    EXPECT_EQ(f[0].b, 1.0f);
    EXPECT_EQ(f[0].a, 0.5f);
    EXPECT_EQ(f[0].coverage, 15);
    EXPECT_EQ(f[0].draw, 0);
    EXPECT_EQ(f[0].primitive, 4u);  // its line
    EXPECT_EQ(f[1].primitive, 6u);
    const TraceReader reader(path("t"));
    EXPECT_EQ(reader.header().width, 20);
    EXPECT_EQ(reader.header().height, 10);
    EXPECT_EQ(reader.header().samples, 4);
    EXPECT_FALSE(reader.header().camera);
}

TEST_F(Csv, ReadsPremultipliedColourAndAllColumnsInAnyOrder) {
    const std::vector<Fragment> f = import(
        "# samples 2\na,B,G,R,z,y,x,primitive,draw,coverage\r\n0.5,0.1,0.2,0.3,0.75,1,2,2147483647,7,2\r\n");
    ASSERT_EQ(f.size(), 1u);
    EXPECT_EQ(f[0].r, 0.3f);
    EXPECT_EQ(f[0].g, 0.2f);
    EXPECT_EQ(f[0].b, 0.1f);
    EXPECT_EQ(f[0].primitive, 2147483647u);
    EXPECT_EQ(f[0].draw, 7);
    EXPECT_EQ(f[0].coverage, 2);
    const TraceReader reader(path("t"));
    EXPECT_EQ(reader.header().width, 3);  // the bounding box
    EXPECT_EQ(reader.header().height, 2);
    EXPECT_EQ(reader.header().draws.size(), 8u);
}

TEST_F(Csv, FacingIsAColumnOfItsOwnWhereAnyFragmentFacesBack) {
    const std::vector<Fragment> f =
        import("x,y,z,r,g,b,a,facing,primitive\n0,0,0,0,0,0,0,1,5\n0,0,0,0,0,0,0,0,5\n0,0,0,0,0,0,0,1,\n");
    ASSERT_EQ(f.size(), 3u);
    EXPECT_EQ(f[0].primitive, 5u | kBackFacing);
    EXPECT_EQ(f[1].primitive, 5u);
    EXPECT_EQ(f[2].primitive, 4u | kBackFacing);  // its line
    export_csv(path("t"), path("b.csv"));
    EXPECT_THAT(read_file(path("b.csv")),
                HasSubstr("coverage,draw,primitive,facing\n0,0,0,0,0,0,0,1,0,5,1\n0,0,0,0,0,0,0,1,0,5,0\n"));
    import_csv(path("b.csv"), path("c"));
    EXPECT_EQ(hash_of(path("c")), hash_of(path("t")));
    import("x,y,z,r,g,b,a,facing\n0,0,0,0,0,0,0,0\n");
    export_csv(path("t"), path("front.csv"));
    EXPECT_THAT(read_file(path("front.csv")), Not(HasSubstr("facing")));
    EXPECT_THAT(fault("x,y,z,r,g,b,a,facing\n0,0,0,0,0,0,0,2\n"), HasSubstr("'facing' is '2'"));
    EXPECT_THAT(fault("x,y,z,r,g,b,a,primitive\n0,0,0,0,0,0,0,2147483648\n"), HasSubstr("0 to 2147483647"));
}

TEST_F(Csv, ReadsBackgroundAndCamera) {
    import(
        "# made by hand\n# fragments of the moon\n# draws what it sees\n# size 200x100\n# background 0.1 0.2 "
        "3\n# camera 0.5 100 60\nx,y,z,r,g,b,a\n");
    const TraceReader reader(path("t"));
    EXPECT_EQ(reader.header().background, glm::vec3(0.1f, 0.2f, 3.0f));
    ASSERT_TRUE(reader.header().camera);
    const Camera& camera = *reader.header().camera;
    EXPECT_EQ(camera.near_plane, 0.5f);
    EXPECT_EQ(camera.far_plane, 100.0f);
    EXPECT_EQ(camera.fovy_degrees, 60.0f);
    // cot(30 degrees) = sqrt(3), aspect 2; the third row maps near to -1 and far to 1.
    EXPECT_FLOAT_EQ(camera.projection[1][1], 1.7320508f);
    EXPECT_FLOAT_EQ(camera.projection[0][0], 1.7320508f / 2);
    EXPECT_FLOAT_EQ(camera.projection[2][2], -100.5f / 99.5f);
    EXPECT_FLOAT_EQ(camera.projection[3][2], -100.0f / 99.5f);
}

TEST_F(Csv, ExportIsLossless) {
    RandomFragments options;
    options.samples = 8;
    options.partial_coverage = true;
    options.draws = 3;
    std::vector<Fragment> fragments = random_fragments(options);
    fragments[0].r = std::numeric_limits<float>::denorm_min();
    fragments[1].g = std::numeric_limits<float>::max();
    fragments[2].b = -0.0f;
    fragments[3].a = 1e-30f;
    write_trace(path("a"), random_header(options), fragments);
    export_csv(path("a"), path("a.csv"));
    import_csv(path("a.csv"), path("b"));
    const std::vector<Fragment> read = read_fragments(path("b"));
    ASSERT_EQ(read.size(), fragments.size());
    EXPECT_EQ(std::memcmp(read.data(), fragments.data(), read.size() * sizeof(Fragment)), 0);
    const TraceReader reader(path("b"));
    EXPECT_EQ(reader.header().background, random_header(options).background);
    EXPECT_EQ(reader.header().samples, 8);
    // A trace that came from CSV survives whole: its hash too.
    export_csv(path("b"), path("b.csv"));
    import_csv(path("b.csv"), path("c"));
    EXPECT_EQ(TraceReader(path("c")).hash(), reader.hash());
    EXPECT_EQ(read_file(path("a.csv")), read_file(path("b.csv")));
}

TEST_F(Csv, FaultsNameLineColumnAndRemedy) {
    const std::string header = "x,y,z,r,g,b,a\n";
    EXPECT_EQ(fault(header + "0,0,0,0,0,0,0\n1,2,0.5,0,0,0,1.5\n"),
              ":3: column 'a' is '1.5': must be a number from 0 to 1");
    EXPECT_EQ(fault(header + "1,2,-0.5,0,0,0,1\n"), ":2: column 'z' is '-0.5': must be a number from 0 to 1");
    EXPECT_EQ(fault(header + "1,2,0.5,nan,0,0,1\n"), ":2: column 'r' is 'nan': must be a finite number");
    EXPECT_EQ(fault(header + "1,2,0.5,1e99,0,0,1\n"), ":2: column 'r' is '1e99': must be a finite number");
    EXPECT_EQ(fault(header + "1,2,0.5,1e999,0,0,1\n"), ":2: column 'r' is '1e999': must be a finite number");
    EXPECT_EQ(fault(header + "1,2,0.5,,0,0,1\n"), ":2: column 'r' is '': must be a finite number");
    EXPECT_EQ(fault(header + "1,2,0.5x,0,0,0,1\n"), ":2: column 'z' is '0.5x': must be a number from 0 to 1");
    EXPECT_EQ(fault(header + "1.5,2,0.5,0,0,0,1\n"),
              ":2: column 'x' is '1.5': must be an integer from 0 to 16383");
    EXPECT_EQ(fault("# size 4x4\n" + header + "1,4,0.5,0,0,0,1\n"),
              ":3: column 'y' is '4': must be an integer from 0 to 3");
    EXPECT_EQ(fault(header + "1,2,0.5,0,0,0\n"), ":2: has 6 fields where the header names 7 columns");
    EXPECT_EQ(fault("x,y,z,r,g,b,a,coverage\n1,2,0.5,0,0,0,1,2\n"),
              ":2: column 'coverage' is '2': must be an integer from 0 to 1");
    EXPECT_EQ(entries(), 1u);  // no trace, no temporary
}

TEST_F(Csv, HeaderAndPreambleFaults) {
    EXPECT_THAT(fault(""), HasSubstr("ends before its header"));
    EXPECT_THAT(fault("1,2,3\n"), HasSubstr(":1: column '1' is unknown"));
    EXPECT_THAT(fault("x,y,z,r,g,b\n"), HasSubstr("column 'a' is missing"));
    EXPECT_THAT(fault("x,y,z,R,g,b,a\n"), HasSubstr("mixes"));
    EXPECT_THAT(fault("x,y,z,r,g,b,a,x\n"), HasSubstr("column 'x' is there twice"));
    EXPECT_THAT(fault("x,y,z,r,g,b,a,depth\n"), HasSubstr("column 'depth' is unknown"));
    EXPECT_THAT(fault("# color_storage double\n"), HasSubstr("must be float16 or float32"));
    EXPECT_THAT(fault("# non_finite 2\n"), HasSubstr("non_finite is '2'"));
    EXPECT_THAT(fault("# draws -1\n"), HasSubstr("draws is '-1'"));
    EXPECT_THAT(fault("# draws 2\nx,y,z,r,g,b,a,draw\n0,0,0,0,0,0,0,2\n"),
                HasSubstr(":3: column 'draw' is '2': must be an integer from 0 to 1"));
    EXPECT_THAT(fault("# draws 0\n# size 2x2\nx,y,z,r,g,b,a\n0,0,0,0,0,0,0\n"),
                HasSubstr(":4: a fragment where"));
    EXPECT_THAT(fault(std::string(70000, 'x')), HasSubstr("a line of more than 65536 bytes"));
    EXPECT_THAT(fault("x,y,z,r,g,b,a\n"), HasSubstr("# size WIDTHxHEIGHT"));
    EXPECT_THAT(fault("# size 0x5\n"), HasSubstr(":1: '# size 0x5': write"));
    EXPECT_THAT(fault("# size 5\n"), HasSubstr("write # size WIDTHxHEIGHT"));
    EXPECT_THAT(fault("# samples 3\n"), HasSubstr("1, 2, 4, 8 or 16"));
    EXPECT_THAT(fault("# background 1 2\n"), HasSubstr("write # background R G B"));
    EXPECT_THAT(fault("# camera 2 1 60\n"), HasSubstr("0 < NEAR < FAR"));
    EXPECT_THROW(import_csv(path("missing.csv"), path("t")), UserError);
}

TEST_F(Csv, ChannelsAreColumnsOfTheirOwn) {
    import("# size 4x4\nx,y,z,r,g,b,a,eta,tg,nx,dzdy\n1,2,0.5,1,1,1,0.5,1.25,0.75,-1,1e-3\n");
    const FragmentChunk read = read_raw(path("t"));
    ASSERT_EQ(read.materials.size(), 1u);
    ASSERT_EQ(read.slopes.size(), 1u);
    const Material& m = read.materials[0];
    EXPECT_TRUE(m.eta == 1.25f && m.transmission[1] == 0.75f && m.normal[0] == -1.0f);
    EXPECT_TRUE(m.transmission[0] == 0 && m.collimation == 1 && m.normal[2] == 1);  // defaults
    EXPECT_TRUE(read.slopes[0].dx == 0 && read.slopes[0].dy == 1e-3f);
    const std::string header = "x,y,z,r,g,b,a,tr,collimation,eta,dzdx\n";
    EXPECT_EQ(fault(header + "0,0,0,0,0,0,0,1.5,0,1,0\n"),
              ":2: column 'tr' is '1.5': must be a number from 0 to 1");
    EXPECT_EQ(fault(header + "0,0,0,0,0,0,0,1,-1,1,0\n"),
              ":2: column 'collimation' is '-1': must be a number from 0 to 1");
    EXPECT_EQ(fault(header + "0,0,0,0,0,0,0,1,1,1,inf\n"),
              ":2: column 'dzdx' is 'inf': must be a finite number");
}

TEST_F(Csv, EveryChannelSurvivesBitForBit) {
    RandomFragments options;
    options.count = 3000;
    options.samples = 4;
    options.partial_coverage = true;
    options.draws = 3;
    for (int kind = 0; kind < 8; ++kind) {
        options.slopes = (kind & 1) != 0;
        options.materials = (kind & 2) != 0;
        options.color_storage = (kind & 4) != 0 ? ColorStorage::kFloat16 : ColorStorage::kFloat32;
        write_random(path("a"), options);
        export_csv(path("a"), path("a.csv"));
        EXPECT_TRUE(import_csv(path("a.csv"), path("b")).empty());
        EXPECT_TRUE(same_content(read_raw(path("a")), read_raw(path("b")))) << kind;
        EXPECT_EQ(TraceReader(path("b")).header().color_storage, options.color_storage);
    }
}

TEST_F(Csv, ValuesThatAreNotFiniteSurviveToo) {
    for (const StressTrace& stress : stress_traces()) {
        if (std::string(stress.name) == "thin_media") continue;  // many, and nothing special as text
        write_stress_trace(stress.name, path("a"));
        export_csv(path("a"), path("a.csv"));
        import_csv(path("a.csv"), path("b"));
        EXPECT_TRUE(same_content(read_raw(path("a")), read_raw(path("b")))) << stress.name;
        EXPECT_EQ(TraceReader(path("b")).header().non_finite, TraceReader(path("a")).header().non_finite);
    }
    for (const std::uint32_t bits : {0x7FC00000u, 0xFFC00000u, 0x7F800001u, 0xFFFFFFFFu}) {
        TraceHeader header;
        header.width = header.height = 1;
        header.draws.resize(1);
        header.non_finite = true;
        const auto odd = std::bit_cast<float>(bits);
        FragmentChunk content;
        content.fragments.push_back({odd, odd, 1, 1, odd, 0, 0, 0, 1, 0});
        write_whole(path("a"), header, content);
        export_csv(path("a"), path("a.csv"));
        import_csv(path("a.csv"), path("b"));
        EXPECT_TRUE(same_content(read_raw(path("b")), content)) << std::hex << bits;
    }
    EXPECT_FALSE(csv_real("nan(0x3f800000)"));  // 1
    EXPECT_FALSE(csv_real("nan(0x7fc00000"));
    EXPECT_FALSE(csv_real("nan(0x)"));
}

// A file without checksums: cut short or changed it must be an error or some other fragments, nothing worse.
TEST_F(Csv, DamageIsAnErrorOrOtherNumbers) {
    write_random(path("a"), {.count = 40, .draws = 2, .slopes = true, .materials = true});
    export_csv(path("a"), path("a.csv"));
    const std::string good = read_file(path("a.csv"));
    const auto survives = [&](const std::string& content) {
        std::filesystem::remove(path("f.csv"));
        std::ofstream(path("f.csv"), std::ios::binary) << content;  // write_file waits for the disk
        std::vector<std::string> notes;
        try {
            notes = import_csv(path("f.csv"), path("t"));
        } catch (const UserError& error) {
            EXPECT_EQ(error.where().find(path("f.csv")), 0u) << error.what();
            return true;
        }
        return !notes.empty();
    };
    EXPECT_FALSE(survives(good));
    for (std::size_t percent = 0; percent < 100; ++percent) {
        const std::string cut = good.substr(0, good.size() * percent / 100);
        // All but the last line is there or it is noticed; that one may have lost digits.
        if (percent < 95) {
            EXPECT_TRUE(survives(cut)) << percent << "%";
        }
    }
    for (std::size_t byte = 0; byte < good.size(); byte += 7) {
        std::string bad = good;
        bad[byte] = static_cast<char>(bad[byte] ^ (1 << (byte % 8)));
        survives(bad);
    }
}

TEST_F(Csv, LinesMayLieAcrossBuffers) {
    std::string text = "x,y,z,r,g,b,a,primitive\r\n";
    constexpr int kRows = 60000;  // 2.4 MB, three buffers
    for (int i = 0; i < kRows; ++i)
        text += fmt::format("{},{},0.12345678,0.5,0.25,0.125,1,{}\r\n", i % 16384, i / 16384, i);
    text.resize(text.size() - 2);  // no line break at the end
    const std::vector<Fragment> f = import(text);
    ASSERT_EQ(f.size(), static_cast<std::size_t>(kRows));
    for (int i = 0; i < kRows; ++i) {
        ASSERT_EQ(f[static_cast<std::size_t>(i)].primitive, static_cast<std::uint32_t>(i));
        ASSERT_EQ(f[static_cast<std::size_t>(i)].x, i % 16384);
    }
}

}  // namespace
}  // namespace ropsim
