// Our own deep OpenEXR files: nothing is lost, the file is what docs/interchange.md says, edits are noticed.
#include "traces/interchange/deep_exr.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/deep_exr_writer.h"
#include "tests/traces/trace_conversion.h"
#include "traces/interchange/deep_exr_records.h"
#include "traces/stress_traces.h"
#include "traces/trace_header.h"

#include <bit>

#include <ImfDeepImageStateAttribute.h>
#include <ImfDeepScanLineInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

class DeepExr : public ScratchTest {
 protected:
    void expect_round_trip(const std::string& trace) {
        export_deep_exr(path(trace), path("f.exr"));
        EXPECT_TRUE(import_deep_exr(path("f.exr"), path("back")).empty());
        EXPECT_EQ(hash_of(path("back")), hash_of(path(trace)));
        EXPECT_TRUE(same_content(read_raw(path("back")), read_raw(path(trace))));
        const TraceReader before(path(trace));
        const TraceReader after(path("back"));
        EXPECT_EQ(header_text(after.header(), 8), header_text(before.header(), 8));
        ASSERT_EQ(after.header().opaque.has_value(), before.header().opaque.has_value());
        if (!before.header().opaque) return;
        EXPECT_TRUE(same_bits(after.header().opaque->rgb, before.header().opaque->rgb));
        EXPECT_TRUE(same_bits(after.header().opaque->depth, before.header().opaque->depth));
    }
    std::string fault(const std::string& file) {
        try {
            import_deep_exr(path(file), path("t"));
        } catch (const UserError& error) {
            EXPECT_EQ(error.where(), path(file));
            return error.what();
        }
        return "(accepted)";
    }
};

TEST_F(DeepExr, NothingIsLost) {
    RandomFragments options;
    options.width = 37;
    options.height = 29;
    options.count = 5000;
    options.draws = 3;
    for (int kind = 0; kind < 16; ++kind) {
        options.slopes = (kind & 1) != 0;
        options.materials = (kind & 2) != 0;
        options.opaque = (kind & 4) != 0;
        options.color_storage = (kind & 8) != 0 ? ColorStorage::kFloat16 : ColorStorage::kFloat32;
        options.samples = kind % 3 == 0 ? 1 : 4;
        options.partial_coverage = options.samples > 1;
        SCOPED_TRACE(kind);
        TraceHeader header = random_header(options);
        header.scene = "all kinds";
        header.camera.emplace().view[3] = {1, 2, 3, 1};
        header.light.emplace().far_plane = std::numeric_limits<float>::infinity();
        header.draws[1].blend = BlendMode::kAdditive;
        FragmentChunk content = random_chunk(options);
        for (std::size_t i = 0; i < content.size(); i += 3) content.fragments[i].primitive |= kBackFacing;
        write_whole(path("t"), header, content);
        expect_round_trip("t");
    }
}

TEST_F(DeepExr, NorAtTheEdges) {
    for (const char* name : {"non_finite", "empty", "single_fragment", "deep_pixel", "depth_ends"}) {
        SCOPED_TRACE(name);
        write_stress_trace(name, path(name));
        expect_round_trip(name);
    }
}

TEST_F(DeepExr, NorBitsOfNans) {
    TraceHeader header;
    header.width = header.height = 1;
    header.non_finite = true;
    header.draws.resize(1);
    FragmentChunk content;
    for (const std::uint32_t bits :
         {0x7F800001u, 0xFFC00000u, 0xFFFFFFFFu, 0x7FC12345u, 0xFF800000u, 0x80000000u}) {
        const auto odd = std::bit_cast<float>(bits);
        content.fragments.push_back({odd, odd, odd, odd, odd, 0, 0, 7, 1, 0});
    }
    write_whole(path("t"), header, content);
    expect_round_trip("t");
}

// Reading in bands must not change anything, in particular not the arrival numbers.
TEST_F(DeepExr, BandsMakeTheSameFile) {
    write_random(path("t"), {.height = 61, .slopes = true});
    export_deep_exr(path("t"), path("whole.exr"));
    export_deep_exr(path("t"), path("bands.exr"), 1000);
    EXPECT_EQ(read_file(path("whole.exr")), read_file(path("bands.exr")));
}

TEST_F(DeepExr, OtherProgramsFindWhatIsDocumented) {
    const RandomFragments options{.width = 20,
                                  .height = 11,
                                  .samples = 2,
                                  .count = 700,
                                  .opaque = true,
                                  .slopes = true,
                                  .materials = true,
                                  .color_storage = ColorStorage::kFloat16};
    write_random(path("t"), options);
    export_deep_exr(path("t"), path("f.exr"));
    Imf::MultiPartInputFile file(path("f.exr").c_str());
    ASSERT_EQ(file.parts(), 2);
    const Imf::Header& deep = file.header(0);
    EXPECT_EQ(deep.name(), "fragments");
    EXPECT_EQ(deep.type(), "deepscanline");
    EXPECT_EQ(Imf::deepImageState(deep), Imf::DIS_MESSY);
    EXPECT_EQ(deep.typedAttribute<Imf::StringAttribute>("ropsim.hash").value(), hash_of(path("t")));
    std::map<std::string, Imf::PixelType> types;
    for (auto c = deep.channels().begin(); c != deep.channels().end(); ++c)
        types[c.name()] = c.channel().type;
    const std::map<std::string, Imf::PixelType> documented{{"Z", Imf::FLOAT},
                                                           {"A", Imf::FLOAT},
                                                           {"R", Imf::HALF},
                                                           {"G", Imf::HALF},
                                                           {"B", Imf::HALF},
                                                           {"order", Imf::UINT},
                                                           {"coverage", Imf::UINT},
                                                           {"draw", Imf::UINT},
                                                           {"primitive", Imf::UINT},
                                                           {"slope.dx", Imf::FLOAT},
                                                           {"slope.dy", Imf::FLOAT},
                                                           {"transmission.R", Imf::HALF},
                                                           {"transmission.G", Imf::HALF},
                                                           {"transmission.B", Imf::HALF},
                                                           {"collimation", Imf::HALF},
                                                           {"eta", Imf::HALF},
                                                           {"N.X", Imf::HALF},
                                                           {"N.Y", Imf::HALF},
                                                           {"N.Z", Imf::HALF}};
    EXPECT_EQ(types, documented);
    EXPECT_EQ(file.header(1).name(), "opaque");
    for (const char* name : {"sample0.R", "sample0.G", "sample0.B", "sample0.Z", "sample1.Z"})
        EXPECT_NE(file.header(1).channels().findChannel(name), nullptr) << name;
    // Within a pixel the samples stand as they arrived.
    struct Numbered {
        std::uint32_t order;
        float z;
    };
    Imf::DeepScanLineInputPart part(file, 0);
    DeepRow<Numbered> row(
        0, 20, {{"order", Imf::UINT, offsetof(Numbered, order)}, {"Z", Imf::FLOAT, offsetof(Numbered, z)}});
    part.setFrameBuffer(row.frame());
    const std::vector<Fragment> fragments = random_fragments(options);
    std::size_t seen = 0;
    for (int y = 0; y < 11; ++y) {
        part.readPixelSampleCounts(y);
        row.allocate();
        part.readPixels(y);
        const Numbered* next = row.records().data();
        for (int x = 0; x < 20; ++x)
            for (std::uint32_t k = 0; k < row.counts()[static_cast<std::size_t>(x)]; ++k, ++next, ++seen) {
                const Fragment& f = fragments.at(next->order);
                EXPECT_TRUE(f.x == x && f.y == y && f.z == next->z);
                if (k > 0) {
                    EXPECT_LT((next - 1)->order, next->order);
                }
            }
    }
    EXPECT_EQ(seen, 700u);
}

TEST_F(DeepExr, AnEditedFileIsRefusedUnlessTakenAsAnyOther) {
    write_random(path("t"), {.count = 100});
    const std::string hash = hash_of(path("t"));
    export_deep_exr(path("t"), path("f.exr"));
    std::string content = read_file(path("f.exr"));
    const std::size_t at = content.find(hash);
    content[at] = content[at] == '0' ? '1' : '0';
    write_file(path("f.exr"), content);
    EXPECT_THAT(fault("f.exr"), HasSubstr("does not match its attribute ropsim.hash"));
    import_deep_exr(path("f.exr"), path("any"), {DeepOrder::kFile, 0});
    EXPECT_EQ(TraceReader(path("any")).fragment_count(), 100u);
}

// Files with our header whose samples are not what our export writes.
TEST_F(DeepExr, ForgedSamplesAreNamedByPixel) {
    TraceHeader header;
    header.width = 4;
    header.height = 3;
    header.samples = 2;
    header.draws.resize(2);
    DeepPicture<DeepRecord> picture;
    picture.window = {{0, 0}, {3, 2}};
    picture.channels = fragment_channels(header);
    const auto fault_of = [&](DeepRecord second) {
        DeepRecord first{};
        first.coverage = 3;
        picture.samples[{1, 0}] = {first};
        picture.samples[{2, 1}] = {second};
        Imf::Header file = picture.header();
        file.insert("ropsim.header", Imf::StringAttribute(header_text(header, 8)));
        picture.write(path("f.exr"), file);
        return fault("f.exr");
    };
    DeepRecord good{};
    good.order = 1;
    good.coverage = 2;
    good.draw = 1;
    good.z = 0.5f;
    EXPECT_THAT(fault_of(good), HasSubstr("ropsim.hash"));  // all but the hash is in order
    const auto with = [&](auto change) {
        DeepRecord bad = good;
        change(bad);
        return fault_of(bad);
    };
    EXPECT_THAT(with([](DeepRecord& r) { r.order = 0; }),
                HasSubstr("pixel (2, 1): arrival number 0 is there twice"));
    EXPECT_THAT(with([](DeepRecord& r) { r.order = 2; }), HasSubstr("arrival number 2 is beyond the last"));
    EXPECT_THAT(with([](DeepRecord& r) { r.draw = 2; }), HasSubstr("pixel (2, 1): draw 2 or coverage 2"));
    EXPECT_THAT(with([](DeepRecord& r) { r.coverage = 4; }), HasSubstr("draw 1 or coverage 4"));
    EXPECT_THAT(with([](DeepRecord& r) { r.a = 2; }), HasSubstr("pixel (2, 1): a value is out of range"));
    header.width = 5;
    EXPECT_THAT(fault_of(good), HasSubstr("does not match the 5x3 pixels"));
    header.width = 4;
    header.depth_slopes = true;
    EXPECT_THAT(fault_of(good), HasSubstr("channel 'slope.dx' is missing"));
    EXPECT_EQ(entries(), 1u);
}

}  // namespace
}  // namespace ropsim
