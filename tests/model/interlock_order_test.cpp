// The interlock's table against a plain list, and fragments put into a recorded order against a trace that
// has it.
#include "model/interlock_order.h"

#include "model/interlock_cost.h"
#include "model/interlock_table.h"
#include "tests/model/machine_driver.h"

#include <algorithm>
#include <set>

namespace ropsim {
namespace {

struct Waiter {
    std::uint32_t slot, quad, pixels;
    bool granted;
};

// In order of arrival; who is granted, and who may be, found by looking at all of them.
class PlainTable {
 public:
    std::vector<Waiter> list;
    Waiter& find(std::uint32_t slot) { return *std::ranges::find(list, slot, &Waiter::slot); }
    bool conflicts(std::uint32_t slot, bool with_waiting) {
        const Waiter own = find(slot);
        bool earlier = true;
        for (const Waiter& w : list) {
            if (w.slot == slot) earlier = false;
            if (w.slot == slot || w.quad != own.quad || (w.pixels & own.pixels) == 0) continue;
            if (w.granted || (with_waiting && earlier)) return true;
        }
        return false;
    }
};

TEST(InterlockTableTest, AgreesWithAPlainList) {
    constexpr std::uint32_t kSlots = 24;
    InterlockTable table(kSlots);
    PlainTable plain;
    std::vector<std::uint32_t> free;
    for (std::uint32_t s = 0; s < kSlots; ++s) free.push_back(s);
    std::uint64_t seed = 7;
    const auto random = [&seed](std::uint64_t below) {
        seed = seed * 6364136223846793005ull + 1442695040888963407ull;
        return static_cast<std::uint32_t>((seed >> 33) % below);
    };
    int releases = 0;
    for (int step = 0; step < 20000; ++step) {
        if (!free.empty() && random(2) == 0) {
            const std::uint32_t slot = free.back();
            free.pop_back();
            const std::uint32_t quad = random(5);
            const std::uint32_t pixels = 1 + random(15);
            table.add(slot, quad, pixels);
            plain.list.push_back({slot, quad, pixels, false});
            EXPECT_EQ(table.held(slot), plain.conflicts(slot, false));
            ASSERT_EQ(table.preceded(slot), plain.conflicts(slot, true));
            if (!table.preceded(slot)) {
                table.grant(slot);
                plain.find(slot).granted = true;
            }
        } else if (!plain.list.empty()) {
            const Waiter leaves = plain.list[random(plain.list.size())];
            if (!leaves.granted) continue;
            ++releases;
            std::set<std::uint32_t> next;
            table.release(leaves.slot, [&](std::uint32_t slot) { next.insert(slot); });
            std::erase_if(plain.list, [&](const Waiter& w) { return w.slot == leaves.slot; });
            free.push_back(leaves.slot);
            std::set<std::uint32_t> expected;
            for (const Waiter& w : plain.list)
                if (!w.granted && w.quad == leaves.quad && !plain.conflicts(w.slot, true))
                    expected.insert(w.slot);
            ASSERT_EQ(next, expected);
            for (const std::uint32_t slot : next) {
                std::set<std::uint32_t> overtaken;
                table.for_overtaken(slot, [&](std::uint32_t other) { overtaken.insert(other); });
                std::set<std::uint32_t> waiting;
                for (const Waiter& w : plain.list) {
                    if (w.slot == slot) break;
                    if (!w.granted && w.quad == leaves.quad) waiting.insert(w.slot);
                }
                EXPECT_EQ(overtaken, waiting);
                table.grant(slot);
                plain.find(slot).granted = true;
            }
        }
    }
    EXPECT_GT(releases, 3000);
}

class InterlockOrderTest : public ModelTest {
 protected:
    static Image image_of(Frame& frame) {
        QuadBatch batch;
        while (frame.advance(batch)) {
        }
        return frame.image();
    }
};

// Recorded last to first; the frame over them is that of a trace written last to first, pixel by pixel.
TEST_F(InterlockOrderTest, AFrameInARecordedOrderIsThatOfATraceWrittenInIt) {
    RandomFragments options;
    options.width = 40;
    options.height = 24;
    options.count = 8000;
    options.opaque = true;
    options.alpha_low = -0.1f;  // clamped below: some without effect
    std::vector<Fragment> fragments = random_fragments(options);
    for (Fragment& f : fragments)
        if (f.a <= 0.0f) f.r = f.g = f.b = f.a = 0.0f;
    const TraceHeader header = random_header(options);
    const MachineConfig config = interlock_machine(configured());
    const std::string forward = write(header, fragments, "forward");
    std::ranges::reverse(fragments);
    const std::string backward = write(header, fragments, "backward");
    for (const char* technique : {"alpha_blend", "mlab:layers=2", "moment_based:moments=4"}) {
        TraceReader trace(forward);
        const auto operation = operation_for(technique, trace.header());
        Frame recorded(trace, *operation, config, 1, true);
        InterlockOrder order(trace.tile_fragments(), recorded.pass_names().size());
        struct Seen {
            std::uint8_t pass;
            std::uint32_t quad, pixels;
            InterlockOrder::Ordinals ordinals;
        };
        std::vector<Seen> seen;
        QuadBatch batch;
        while (recorded.advance(batch))
            for (const QuadOperation& q : batch.quads)
                if (q.kind == QuadKind::kDraw && q.pixels != 0)
                    seen.push_back(
                        {batch.pass, q.quad_id, q.pixels, order.arrive(batch.pass, q.quad_id, q.pixels)});
        std::ranges::reverse(seen);
        for (const Seen& s : seen) order.operate(s.pass, s.quad, s.pixels, s.ordinals, 0);
        InterlockReplay replay(trace, operation->declaration(), order);
        Frame replayed(trace, *operation, config, 2, false);
        replayed.take_fragments_from(replay);
        const Image image = image_of(replayed);
        EXPECT_EQ(replayed.fragments().operated, recorded.fragments().operated);
        EXPECT_EQ(replayed.fragments().depth_culled, recorded.fragments().depth_culled);
        EXPECT_EQ(replayed.fragments().zero_alpha, recorded.fragments().zero_alpha);
        EXPECT_GT(recorded.fragments().depth_culled, 0u);
        TraceReader reversed(backward);
        Frame straight(reversed, *operation, config, 1, false);
        EXPECT_EQ(image.values, image_of(straight).values) << technique;
        EXPECT_NE(image.values, recorded.image().values) << technique;
    }
}

TEST_F(InterlockOrderTest, WhatHasNoOrderOfItsOwnIsSaidToHaveNone) {
    const TraceHeader header = plain_header(16, 16);
    EXPECT_EQ(no_replay(operation_for("alpha_blend", header)->declaration()), "");
    EXPECT_EQ(no_replay(operation_for("moment_based:moments=4", header)->declaration()), "");
    EXPECT_NE(no_replay(operation_for("depth_peeling", header)->declaration()), "");
}

// A share of the L2 has the configuration's slice, or else the ROP cache's size and shape.
TEST(InterlockMachineTest, TheCacheIsTheL2s) {
    const MachineConfig without = configured({"cache.kibibytes=24", "cache.ways=6", "cache.line_bytes=128"});
    const MachineConfig stands_in = interlock_machine(without);
    EXPECT_EQ(stands_in.l2.cache.size_bytes, 24u * 1024);
    EXPECT_EQ(stands_in.l2.cache.ways, 6u);
    EXPECT_EQ(stands_in.l2.latency, without.l2.latency);
    EXPECT_TRUE(stands_in.interlock.executes);
    EXPECT_FALSE(stands_in.fast_clear);
    const MachineConfig with = interlock_machine(configured({"l2.kibibytes=256", "l2.ways=8"}));
    EXPECT_EQ(with.l2.cache.size_bytes, 256u * 1024);
    EXPECT_EQ(with.l2.cache.ways, 8u);
}

}  // namespace
}  // namespace ropsim
