// Damaged and lying deep OpenEXR files: an error or the same data; never a crash, a hang or memory for the
// asking.
#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/deep_exr_writer.h"
#include "tests/traces/trace_conversion.h"
#include "traces/interchange/deep_exr.h"
#include "traces/interchange/deep_exr_foreign.h"
#include "traces/interchange/deep_exr_own.h"
#include "traces/trace_header.h"

#include <cstring>
#include <fstream>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

class DeepExrDamage : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        options_.width = 6;
        options_.height = 4;
        options_.samples = 2;
        options_.count = 24;
        options_.opaque = options_.slopes = options_.materials = true;
        write_random(path("t"), options_);
        export_deep_exr(path("t"), path("own.exr"));
        own_ = read_file(path("own.exr"));
        DeepPicture<PlainSample> picture = plain_picture(-2, 5, 6, 4);
        for (const Fragment& f : random_fragments(options_))
            picture.samples[{f.x - 2, f.y + 5}].push_back({20 * f.z, f.r, f.g, f.b, f.a});
        picture.write(path("foreign.exr"));
        foreign_ = read_file(path("foreign.exr"));
        std::filesystem::remove(path("t"));
    }
    // A new file each time, not write_file: that waits for the disk, thousands of times.
    void put(const std::string& content) const {
        std::filesystem::remove(path("bad.exr"));
        std::ofstream(path("bad.exr"), std::ios::binary) << content;
    }
    // The message that reading `content` ends in; nothing where all of it was read, and is as it was.
    std::optional<std::string> read_own(const std::string& content) {
        put(content);
        try {
            return with_exr_faults(path("bad.exr"), [&]() -> std::optional<std::string> {
                DeepExrFile file(path("bad.exr"));
                if (!is_own_deep_exr(file)) return "not our own";
                const OwnDeepExr own = read_own_deep_exr(file);
                TraceHeader header = random_header(options_);
                EXPECT_EQ(header_content_text(own.header), header_content_text(header));
                EXPECT_TRUE(same_bits(own.header.opaque->rgb, header.opaque->rgb));
                EXPECT_TRUE(same_content(own.content, random_chunk(options_)));
                return std::nullopt;
            });
        } catch (const UserError& error) {
            EXPECT_EQ(error.where(), path("bad.exr"));
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
            return error.what();
        }
    }
    std::string refused_foreign(const std::string& content) {
        return read_foreign(content).value_or("(accepted)");
    }
    std::optional<std::string> read_foreign(const std::string& content) {
        put(content);
        try {
            return with_exr_faults(path("bad.exr"), [&]() -> std::optional<std::string> {
                DeepExrFile file(path("bad.exr"));
                const ForeignDeepImage image = read_foreign_deep_exr(file);
                for (const DeepOrder order : {DeepOrder::kShuffle, DeepOrder::kFarToNear})
                    emit_in_rounds(image, order, 0, [](const std::vector<Fragment>&) {});
                return std::nullopt;
            });
        } catch (const UserError& error) {
            EXPECT_EQ(error.where(), path("bad.exr"));
            return error.what();
        }
    }

    RandomFragments options_;
    std::string own_, foreign_;
};

TEST_F(DeepExrDamage, TruncationIsAnError) {
    ASSERT_FALSE(read_own(own_));
    ASSERT_FALSE(read_foreign(foreign_));
    for (std::size_t percent = 0; percent < 100; ++percent) {
        EXPECT_TRUE(read_own(own_.substr(0, own_.size() * percent / 100))) << percent << "%";
        EXPECT_TRUE(read_foreign(foreign_.substr(0, foreign_.size() * percent / 100))) << percent << "%";
    }
    EXPECT_TRUE(read_own(own_.substr(0, own_.size() - 1)));
}

// In our own files what is read is what was written, or it is an error: the hash sees to it.
TEST_F(DeepExrDamage, FlippedBitsNeverChangeOurOwnData) {
    std::size_t noticed = 0;
    for (std::size_t byte = 0; byte < own_.size(); ++byte) {
        std::string bad = own_;
        bad[byte] = static_cast<char>(bad[byte] ^ (1 << (byte % 8)));
        noticed += read_own(bad) ? 1 : 0;
    }
    // What is left is attributes that mean nothing here, such as the screen window.
    EXPECT_GT(noticed, own_.size() * 8 / 10);
}

// Other programs' files have zlib's checksums at most.
TEST_F(DeepExrDamage, FlippedBitsNeverCrash) {
    for (std::size_t byte = 0; byte < foreign_.size(); ++byte)
        for (const int bit : {0, 3, 7}) {
            std::string bad = foreign_;
            bad[byte] = static_cast<char>(bad[byte] ^ (1 << bit));
            read_foreign(bad);
        }
}

class DeepExrClaims : public DeepExrDamage {
 protected:
    // Where the value of an attribute starts in the foreign file; its size stands in the four bytes before.
    std::size_t value_of(const std::string& attribute, const std::string& type) const {
        const std::string pattern = attribute + '\0' + type + '\0';
        const std::size_t at = foreign_.find(pattern);
        EXPECT_NE(at, std::string::npos);
        return at + pattern.size() + 4;
    }
    // The table of rows follows the header, whose last attribute is the version of deep data.
    std::size_t first_chunk() const {
        std::uint64_t offset = 0;
        const std::size_t table = value_of("version", "int") + sizeof(int) + 1;
        std::memcpy(&offset, foreign_.data() + table, sizeof(offset));
        return offset;
    }
    template <typename T>
    std::string patched(std::size_t at, T value) const {
        std::string bad = foreign_;
        std::memcpy(bad.data() + at, &value, sizeof(value));
        return bad;
    }
    static long peak_megabytes() {
        rusage usage{};
        ::getrusage(RUSAGE_SELF, &usage);
        return usage.ru_maxrss / 1024;
    }
};

TEST_F(DeepExrClaims, AreHeldAgainstTheFileBeforeMemoryIsTaken) {
    const long before = peak_megabytes();
    const std::size_t window = value_of("dataWindow", "box2i");
    EXPECT_THAT(refused_foreign(patched(window + 8, 2000000000)), HasSubstr("1 to 16384 a side"));
    EXPECT_THAT(refused_foreign(patched(window + 12, 16000)),
                HasSubstr("4 chunks are claimed for 15996 rows"));
    EXPECT_THAT(refused_foreign(patched(window + 8, -100)), HasSubstr("1 to 16384 a side"));
    EXPECT_THAT(refused_foreign(patched(value_of("chunkCount", "int"), 2000000000)),
                HasSubstr("chunks are claimed"));
    EXPECT_THAT(refused_foreign(patched(value_of("channels", "chlist") - 4, 0x7FFFFFFF)),
                HasSubstr("bytes are claimed where"));
    EXPECT_THAT(refused_foreign(patched(value_of("type", "string") - 4, 0x7FFFFFF0)),
                HasSubstr("bytes are claimed where"));
    const std::size_t chunk = first_chunk();
    const auto huge = std::uint64_t{1} << 60;
    EXPECT_THAT(refused_foreign(patched(chunk + 4, huge)),
                HasSubstr("bytes are claimed where"));  // its table
    EXPECT_THAT(refused_foreign(patched(chunk + 12, huge)),
                HasSubstr("bytes are claimed where"));                                   // its samples
    EXPECT_THAT(refused_foreign(patched(chunk + 20, huge)), HasSubstr("row 5 claims"));  // unpacked
    EXPECT_THAT(refused_foreign(patched(chunk + 20, std::uint64_t{4000})),
                HasSubstr("do not fit its 4000 bytes"));
    EXPECT_LT(peak_megabytes() - before, 100);
}

// Counts of samples that add up to 10^9 in a file of a few hundred bytes, stored as they are.
TEST_F(DeepExrClaims, ABillionSamplesInAFewBytes) {
    DeepPicture<PlainSample> picture = plain_picture(0, 0, 1, 1);
    picture.compression = Imf::NO_COMPRESSION;
    picture.samples[{0, 0}] = {{1, 0, 0, 0, 1}};
    picture.write(path("foreign.exr"));
    foreign_ = read_file(path("foreign.exr"));
    ASSERT_FALSE(read_foreign(foreign_));
    const long before = peak_megabytes();
    const std::size_t chunk = first_chunk();
    EXPECT_NE(refused_foreign(patched(chunk + 28, 1000000000)), "(accepted)");
    EXPECT_NE(refused_foreign(patched(chunk + 28, -5)), "(accepted)");
    EXPECT_THAT(refused_foreign(patched(chunk + 20, std::uint64_t{20000})), HasSubstr("claims 20000 bytes"));
    EXPECT_LT(peak_megabytes() - before, 100);
}

}  // namespace
}  // namespace ropsim
