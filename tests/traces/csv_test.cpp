// CSV fragments: what is read from them, lossless export, and errors with their places.
#include "traces/csv.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

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
        "# samples 2\na,B,G,R,z,y,x,primitive,draw,coverage\r\n0.5,0.1,0.2,0.3,0.75,1,2,4294967295,7,2\r\n");
    ASSERT_EQ(f.size(), 1u);
    EXPECT_EQ(f[0].r, 0.3f);
    EXPECT_EQ(f[0].g, 0.2f);
    EXPECT_EQ(f[0].b, 0.1f);
    EXPECT_EQ(f[0].primitive, 4294967295u);
    EXPECT_EQ(f[0].draw, 7);
    EXPECT_EQ(f[0].coverage, 2);
    const TraceReader reader(path("t"));
    EXPECT_EQ(reader.header().width, 3);  // the bounding box
    EXPECT_EQ(reader.header().height, 2);
    EXPECT_EQ(reader.header().draws.size(), 8u);
}

TEST_F(Csv, ReadsBackgroundAndCamera) {
    import("# made by hand\n# size 200x100\n# background 0.1 0.2 3\n# camera 0.5 100 60\nx,y,z,r,g,b,a\n");
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
    EXPECT_THAT(fault("x,y,z,r,g,b,a,tr\n"), HasSubstr("column 'tr': this version stores no materials"));
    EXPECT_THAT(fault("x,y,z,r,g,b,a\n"), HasSubstr("# size WIDTHxHEIGHT"));
    EXPECT_THAT(fault("# size 0x5\n"), HasSubstr(":1: '# size 0x5': write"));
    EXPECT_THAT(fault("# size 5\n"), HasSubstr("write # size WIDTHxHEIGHT"));
    EXPECT_THAT(fault("# samples 3\n"), HasSubstr("1, 2, 4, 8 or 16"));
    EXPECT_THAT(fault("# background 1 2\n"), HasSubstr("write # background R G B"));
    EXPECT_THAT(fault("# camera 2 1 60\n"), HasSubstr("0 < NEAR < FAR"));
    EXPECT_THROW(import_csv(path("missing.csv"), path("t")), UserError);
}

}  // namespace
}  // namespace ropsim
