// Address traces as text, and the patterns that are made instead.
#include "memory/address_trace.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "memory/access_pattern.h"
#include "tests/traces/scratch.h"

#include <algorithm>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

std::vector<AddressRequest> all_of(RequestSource& source) {
    std::vector<AddressRequest> all;
    for (std::vector<AddressRequest> block; source.next(block);)
        all.insert(all.end(), block.begin(), block.end());
    return all;
}

class AddressTrace : public ScratchTest {
 protected:
    std::vector<AddressRequest> read(const std::string& text) const {
        write_file(path("t"), text);
        AddressTraceReader reader(path("t"));
        return all_of(reader);
    }
    std::string refusal(const std::string& text) const {
        try {
            read(text);
        } catch (const UserError& error) {
            return error.where() + ": " + error.what();
        }
        return "";
    }
};

TEST_F(AddressTrace, LinesAreRead) {
    const auto all = read("# comment\n0x1F40 READ 5\r\n\n  0Xff\twrite\t3  \n0x0 Read 281474976710655");
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0].address, 0x1f40u);
    EXPECT_FALSE(all[0].write);
    EXPECT_EQ(all[0].cycle, 5u);
    EXPECT_EQ(all[1].address, 0xffu);
    EXPECT_TRUE(all[1].write);
    EXPECT_EQ(all[1].cycle, 3u);
    EXPECT_EQ(all[2].cycle, (std::uint64_t{1} << 48) - 1);
}

TEST_F(AddressTrace, WhatIsWrittenReadsBackAcrossBlocks) {
    std::string text;
    std::vector<AddressRequest> wanted;
    for (std::uint64_t i = 0; i < 50000; ++i) {
        AddressRequest request;
        request.address = i * 0x9E3779B97F4A7C15ull;
        request.cycle = i * i;
        request.write = i % 3 == 0;
        wanted.push_back(request);
        append_trace_line(text, request);
    }
    const auto all = read(text);
    ASSERT_EQ(all.size(), wanted.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        ASSERT_EQ(all[i].address, wanted[i].address);
        ASSERT_EQ(all[i].cycle, wanted[i].cycle);
        ASSERT_EQ(all[i].write, wanted[i].write);
    }
}

TEST_F(AddressTrace, FaultsAreNamedByFileAndLine) {
    using testing::AllOf;
    using testing::HasSubstr;
    const std::string file = path("t");
    const auto names = [&](int line, const std::string& word) {
        return AllOf(HasSubstr(file + ":" + std::to_string(line) + ":"), HasSubstr(word));
    };
    EXPECT_THAT(refusal("0x0 READ 0\n0x40 FETCH 0\n"), names(2, "'FETCH' is neither"));
    EXPECT_THAT(refusal("0x0 READ\n"), names(1, "cycle of arrival is missing"));
    EXPECT_THAT(refusal("# c\n\n0x0\n"), names(3, "READ or WRITE is missing"));
    EXPECT_THAT(refusal("0x0 READ -1\n"), names(1, "'-1' is no cycle"));
    EXPECT_THAT(refusal("0x0 READ 1.5\n"), names(1, "'1.5'"));
    EXPECT_THAT(refusal("0x0 READ 281474976710656\n"), names(1, "2^48"));
    EXPECT_THAT(refusal("40 READ 1\n"), names(1, "'40' is no address"));
    EXPECT_THAT(refusal("0x READ 1\n"), names(1, "'0x'"));
    EXPECT_THAT(refusal("-0x40 READ 1\n"), names(1, "'-0x40'"));
    EXPECT_THAT(refusal("0x10000000000000000 READ 1\n"), names(1, "is no address"));
    EXPECT_THAT(refusal("0x40 READ 1 2\n"), names(1, "'2' after the cycle"));
    EXPECT_THAT(refusal(""), HasSubstr("holds no request"));
    EXPECT_THAT(refusal("# nothing\n"), HasSubstr("holds no request"));
    EXPECT_THAT(refusal("0x40 READ 1\n" + std::string(2000, 'x')), names(2, "over 1000 characters"));
    EXPECT_THAT(refusal("\x1f\x8b\x08"), HasSubstr("zcat"));
    EXPECT_THROW(AddressTraceReader(path("none")), UserError);
    EXPECT_THROW(AddressTraceReader(path("")), UserError);  // a directory
}

// The line number survives blocks.
TEST_F(AddressTrace, ALateFaultIsNamed) {
    std::string text;
    for (int i = 0; i < 60000; ++i) text += "0x40 READ 1\n";
    EXPECT_THAT(refusal(text + "0x40 REED 1\n"), testing::HasSubstr(":60001:"));
}

std::vector<AddressRequest> pattern(const std::string& name, std::uint64_t requests, std::uint64_t span) {
    PatternOptions options;
    options.name = name;
    options.requests = requests;
    options.span = span;
    AccessPattern source(options);
    return all_of(source);
}

TEST(AccessPattern, AddressesAreThePublishedOnes) {
    const auto sequential = pattern("seq_read", 20000, 1 << 20);
    ASSERT_EQ(sequential.size(), 20000u);
    EXPECT_EQ(sequential[16385].address, 64u);
    // from an implementation of SplitMix64 apart, which gives the published 6457827717110365317 for 1234567
    const auto random = pattern("rand_read", 3, std::uint64_t{1} << 30);
    EXPECT_EQ(random[0].address, 0x337266c0u);
    EXPECT_EQ(random[1].address, 0x3093e00u);
    EXPECT_EQ(random[2].address, 0x1b5f740u);
    const auto mixed = pattern("seq_mix50", 10000, std::uint64_t{1} << 30);
    const auto writes = std::count_if(mixed.begin(), mixed.end(), [](const auto& r) { return r.write; });
    EXPECT_NEAR(static_cast<double>(writes), 5000, 200);
    std::set<std::size_t> first;
    for (std::size_t i = 0; i < 12; ++i)
        if (mixed[i].write) first.insert(i);
    EXPECT_EQ(first, (std::set<std::size_t>{2, 5, 6, 8, 10, 11}));
    const auto mixed_randomly = pattern("rand_mix50", 10000, std::uint64_t{1} << 30);
    for (std::size_t i = 0; i < mixed.size(); ++i) {
        EXPECT_EQ(mixed[i].address, i * 64);
        EXPECT_EQ(mixed[i].write, mixed_randomly[i].write);
    }
    for (const auto& r : pattern("seq_write", 100, 1 << 20)) EXPECT_TRUE(r.write);
    EXPECT_EQ(pattern("chase", 10, 1 << 20)[0].needs, 0u);
    EXPECT_EQ(pattern("chase", 10, 1 << 20)[9].needs, 1u);
}

// Every pair once, the write behind the read that it needs.
TEST(AccessPattern, StridedWritesFollowTheirReads) {
    for (const std::uint64_t requests : {2u, 10u, 32u, 34u, 500u}) {
        const auto all = pattern("stride_rmw", requests, 1 << 20);
        ASSERT_EQ(all.size(), requests);
        std::size_t reads = 0, writes = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            EXPECT_EQ(all[i].address, (all[i].write ? writes : reads) * 4096 % (1 << 20));
            ++(all[i].write ? writes : reads);
            EXPECT_LE(reads - writes, 17u);
            if (!all[i].write) continue;
            ASSERT_LE(all[i].needs, i);
            EXPECT_LE(all[i].needs, AccessPattern::kNeeds);
            EXPECT_FALSE(all[i - all[i].needs].write);
            EXPECT_EQ(all[i - all[i].needs].address, all[i].address);
        }
        EXPECT_EQ(reads, writes);
    }
}

TEST(AccessPattern, WhatCannotBeIsRefused) {
    EXPECT_THROW(pattern("zigzag", 10, 1 << 20), UserError);
    EXPECT_THROW(pattern("seq_read", 10, 100), UserError);
    EXPECT_THROW(pattern("seq_read", 10, 0), UserError);
    EXPECT_THROW(pattern("stride_rmw", 10, 2048), UserError);
}

}  // namespace
}  // namespace ropsim
