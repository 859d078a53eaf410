// Damaged trace files: a UserError or the same data, never a crash and never other data.
#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/scratch.h"
#include "tests/traces/trace_round_trip.h"
#include "traces/generators.h"
#include "traces/trace.h"
#include "traces/trace_layout.h"

#include <cstring>
#include <fstream>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <xxhash.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

class TraceDamage : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        RandomFragments options;
        options.width = 40;
        options.height = 24;
        options.count = 300;
        options.opaque = true;
        options.draws = 2;
        TraceWriter writer(path("good"), random_header(options), {120, 16});
        fragments_ = random_fragments(options);
        writer.append(fragments_);
        writer.finish();
        content_ = read_file(path("good"));
    }

    // A new file each time, not write_file: that, as truncating an old one, waits for the disk, thousands of
    // times.
    void put(const std::string& content) const {
        std::filesystem::remove(path("bad"));
        std::ofstream(path("bad"), std::ios::binary) << content;
    }

    // What a program that reads `content` as a trace gets: the message, or nothing when all data is as it
    // was.
    std::optional<std::string> read_damaged(const std::string& content) {
        put(content);
        try {
            TraceReader reader(path("bad"));
            std::vector<Fragment> all;
            std::vector<Fragment> chunk;
            while (reader.next(chunk)) all.insert(all.end(), chunk.begin(), chunk.end());
            EXPECT_EQ(all.size(), fragments_.size());
            EXPECT_TRUE(same_bytes(all, fragments_));
            return std::nullopt;
        } catch (const UserError& error) {
            EXPECT_EQ(error.where(), path("bad"));
            return error.what();
        }
    }

    // Puts a record into the file with its checksum mended, as a forger would.
    template <typename Record>
    void mend(std::string& content, std::size_t offset, Record record) const {
        record.checksum = XXH64(&record, offsetof(Record, checksum), 0);
        std::memcpy(content.data() + offset, &record, sizeof(record));
    }
    template <typename Record>
    Record record_at(std::size_t offset) const {
        Record record;
        std::memcpy(&record, content_.data() + offset, sizeof(record));
        return record;
    }

    std::vector<Fragment> fragments_;
    std::string content_;
};

TEST_F(TraceDamage, TruncationIsDetectedAtOpen) {
    for (std::size_t percent = 0; percent < 100; ++percent) {
        put(content_.substr(0, content_.size() * percent / 100));
        EXPECT_THROW(TraceReader reader(path("bad")), UserError) << percent << "%";
    }
    put(content_.substr(0, content_.size() - 1));
    EXPECT_THROW(TraceReader reader(path("bad")), UserError);
    put(content_ + "x");
    EXPECT_THROW(TraceReader reader(path("bad")), UserError);
}

TEST_F(TraceDamage, EveryFlippedBitIsDetected) {
    ASSERT_FALSE(read_damaged(content_));
    for (std::size_t byte = 0; byte < content_.size(); ++byte) {
        std::string bad = content_;
        bad[byte] = static_cast<char>(bad[byte] ^ (1 << (byte % 8)));
        ASSERT_TRUE(read_damaged(bad)) << "byte " << byte;
    }
}

TEST_F(TraceDamage, MessagesNameThePlace) {
    const auto flipped = [&](std::size_t byte) {
        std::string bad = content_;
        bad[byte] = static_cast<char>(bad[byte] ^ 1);
        return read_damaged(bad).value_or("");
    };
    const auto prologue = record_at<PrologueRecord>(0);
    EXPECT_THAT(flipped(0), HasSubstr("is not a trace file"));
    EXPECT_THAT(flipped(9), HasSubstr("version"));
    EXPECT_THAT(flipped(prologue.header.offset + 5), HasSubstr("the header"));
    EXPECT_THAT(flipped(prologue.opaque.offset + 5), HasSubstr("the opaque layer"));
    EXPECT_THAT(flipped(prologue.opaque.offset + prologue.opaque.stored_bytes + 5),
                HasSubstr("chunk 0, region 0"));
    EXPECT_THAT(flipped(content_.size() - 1), HasSubstr("cut short"));
}

TEST_F(TraceDamage, OtherVersionsAndOtherFilesAreNamed) {
    std::string bad = content_;
    auto prologue = record_at<PrologueRecord>(0);
    prologue.version = 1;
    mend(bad, 0, prologue);
    EXPECT_THAT(read_damaged(bad).value_or(""), HasSubstr("version 1"));
    EXPECT_THAT(read_damaged("").value_or(""), HasSubstr("is not a trace file"));
    EXPECT_THAT(read_damaged("x,y,z,r,g,b,a\n").value_or(""), HasSubstr("is not a trace file"));
    EXPECT_THROW(TraceReader reader(path("missing")), UserError);
    EXPECT_THROW(TraceReader reader("/"), UserError);
}

TEST_F(TraceDamage, ForgedHeaderOfATraceWithoutFragmentsIsDetected) {
    fragments_.clear();
    {
        RandomFragments options;
        options.count = 0;
        TraceWriter(path("empty"), random_header(options)).finish();
    }
    content_ = read_file(path("empty"));
    ASSERT_FALSE(read_damaged(content_));
    auto prologue = record_at<PrologueRecord>(0);
    std::string bad = content_;
    const std::size_t scene = bad.find("random fragments");
    ASSERT_NE(scene, std::string::npos);
    bad[scene] = 'R';
    prologue.header.checksum = XXH64(&bad[prologue.header.offset], prologue.header.stored_bytes, 0);
    mend(bad, 0, prologue);
    EXPECT_THAT(read_damaged(bad).value_or(""), HasSubstr("does not match its hash"));
}

TEST_F(TraceDamage, ForgedSizesAllocateNothing) {
    std::string bad = content_;
    auto prologue = record_at<PrologueRecord>(0);
    prologue.header.stored_bytes = 1000000000000000000u;
    mend(bad, 0, prologue);
    EXPECT_THAT(read_damaged(bad).value_or(""), HasSubstr("outside the file"));

    bad = content_;
    const std::size_t trailer_at = content_.size() - sizeof(TrailerRecord);
    auto trailer = record_at<TrailerRecord>(trailer_at);
    trailer.index_raw_bytes = 1000000000000000000u;
    mend(bad, trailer_at, trailer);
    EXPECT_THAT(read_damaged(bad).value_or(""), HasSubstr("more blocks than the file can hold"));
}

// A header with `from` replaced by `to` (of the same length), its checksums mended.
TEST_F(TraceDamage, ForgedHeadersAreRefused) {
    const auto forged = [&](const std::string& from, const std::string& to) {
        EXPECT_EQ(from.size(), to.size());
        std::string bad = content_;
        auto prologue = record_at<PrologueRecord>(0);
        const std::size_t at = bad.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        bad.replace(at, from.size(), to);
        prologue.header.checksum =
            XXH64(bad.data() + prologue.header.offset, prologue.header.stored_bytes, 0);
        mend(bad, 0, prologue);
        return read_damaged(bad).value_or("(accepted)");
    };
    EXPECT_THAT(forged("\"width\":40", "\"width\":-4"), HasSubstr("size -4x24"));
    EXPECT_THAT(forged("\"width\":40", "\"width\":48"), ::testing::Not(HasSubstr("(accepted)")));
    EXPECT_THAT(forged("\"samples\":1", "\"samples\":3"), HasSubstr("samples 3"));
    EXPECT_THAT(forged("\"width\":40", "\"width\":{}"), HasSubstr("integer"));
    EXPECT_THAT(forged("\"width\":40", "\"wodth\":40"), HasSubstr("width"));
    EXPECT_THAT(forged("\"name\":\"rank\"", "\"name\":\"rink\""),
                HasSubstr("column 'rink' that this version"));
    EXPECT_THAT(forged("float32", "float99"), HasSubstr("float99"));
    EXPECT_THAT(forged("\"region_side\":16", "\"region_side\":15"), HasSubstr("region_side 15"));
    // Half as many regions: the blocks no longer fit theirs.
    EXPECT_THAT(forged("\"region_side\":16", "\"region_side\":24"), ::testing::Not(HasSubstr("(accepted)")));
}

}  // namespace
}  // namespace ropsim
