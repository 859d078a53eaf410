// The hash of a trace: of its content alone, and of all of it.
#include "tests/traces/scratch.h"
#include "tests/traces/trace_round_trip.h"
#include "traces/generators.h"
#include "traces/trace.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using TraceHash = ScratchTest;

TEST_F(TraceHash, IgnoresChunkingAndSeesEveryField) {
    const RandomFragments options = rich_options();
    const TraceHeader header = random_header(options);
    const std::vector<Fragment> fragments = random_fragments(options);
    const auto hash_of = [&](const TraceHeader& h, const std::vector<Fragment>& f,
                             TraceLayoutOptions layout = {}) {
        write(path("t"), h, f, layout);
        return TraceReader(path("t")).hash();
    };
    const std::string hash = hash_of(header, fragments);
    EXPECT_THAT(hash, ::testing::MatchesRegex("[0-9a-f]{16}"));
    EXPECT_EQ(hash_of(header, fragments, {777, 32}), hash);

    std::vector<Fragment> swapped = fragments;
    std::swap(swapped[100], swapped[101]);
    EXPECT_NE(hash_of(header, swapped), hash);
    const std::vector<Fragment> shorter(fragments.begin(), fragments.end() - 1);
    EXPECT_NE(hash_of(header, shorter), hash);
    const auto changed = [&](auto&& change) {
        std::vector<Fragment> other = fragments;
        change(other[5]);
        return hash_of(header, other);
    };
    EXPECT_NE(changed([](Fragment& f) { f.z = std::nextafter(f.z, 2.0f); }), hash);
    EXPECT_NE(changed([](Fragment& f) { f.g += 1; }), hash);
    EXPECT_NE(changed([](Fragment& f) { f.a *= 0.5f; }), hash);
    EXPECT_NE(changed([](Fragment& f) { f.x ^= 1; }), hash);
    EXPECT_NE(changed([](Fragment& f) { f.primitive ^= 1u << 31; }), hash);
    EXPECT_NE(changed([](Fragment& f) { f.coverage ^= 1; }), hash);
    EXPECT_NE(changed([](Fragment& f) { f.draw = static_cast<std::uint16_t>((f.draw + 1) % 5); }), hash);

    const auto changed_header = [&](auto&& change) {
        TraceHeader other = header;
        change(other);
        return hash_of(other, fragments);
    };
    EXPECT_NE(changed_header([](TraceHeader& h) { h.background.g += 0.5f; }), hash);
    EXPECT_NE(changed_header([](TraceHeader& h) { h.opaque->depth[9] = 0.123f; }), hash);
    EXPECT_NE(changed_header([](TraceHeader& h) { h.opaque.reset(); }), hash);
    EXPECT_NE(changed_header([](TraceHeader& h) { h.draws[1].depth_write = true; }), hash);
    EXPECT_NE(changed_header([](TraceHeader& h) { h.camera = Camera{}; }), hash);
}

TEST_F(TraceHash, DoesNotDependOnTheStorageOfTheSameColours) {
    RandomFragments options;
    options.color_storage = ColorStorage::kFloat16;
    TraceHeader header = random_header(options);
    const std::vector<Fragment> fragments = random_fragments(options);
    write(path("half"), header, fragments, {});
    header.color_storage = ColorStorage::kFloat32;
    write(path("float"), header, fragments, {});
    TraceReader half(path("half"));
    TraceReader full(path("float"));
    EXPECT_EQ(half.hash(), full.hash());
    EXPECT_LT(half.file_bytes(), full.file_bytes());
    EXPECT_TRUE(same_bytes(read_all(half), read_all(full)));
}

TEST_F(TraceHash, CoversEveryChannel) {
    RandomFragments options;
    options.count = 100;
    options.slopes = options.materials = true;
    const auto hash_of = [&](auto&& change) {
        FragmentChunk chunk = random_chunk(options);
        change(chunk);
        TraceWriter writer(path("t"), random_header(options));
        writer.append(chunk);
        writer.finish();
        TraceReader reader(path("t"));
        FragmentChunk read;
        while (reader.next(read)) {
        }
        return reader.hash();
    };
    const std::string hash = hash_of([](FragmentChunk&) {});
    EXPECT_EQ(hash_of([](FragmentChunk&) {}), hash);
    EXPECT_NE(hash_of([](FragmentChunk& c) { c.slopes[7].dx += 1e-3f; }), hash);
    EXPECT_NE(hash_of([](FragmentChunk& c) { c.materials[7].normal[1] += 1e-3f; }), hash);
    EXPECT_NE(hash_of([](FragmentChunk& c) { c.fragments[7].z *= 0.5f; }), hash);
}

}  // namespace
}  // namespace ropsim
