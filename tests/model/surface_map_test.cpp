// Addresses of pixels: disjoint, inside their surfaces, evenly shared out; lines merged as a byte map would.
#include "model/surface_map.h"

#include "model/line_collector.h"
#include "tests/model/machine_driver.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct MapCase {
    std::string technique;
    Settings settings;
    int width, height;
};

class Addresses : public ::testing::TestWithParam<MapCase> {};

// Paints every byte of every element; none may be painted twice or lie outside its surface.
class Painter {
 public:
    explicit Painter(const SurfaceMap& map)
        : map_(map),
          owner_(static_cast<std::size_t>(map.partitions()),
                 std::vector<std::uint8_t>(map.partition_bytes())) {}
    void paint(int partition, int surface, std::uint64_t address, std::uint64_t bytes) {
        ASSERT_GE(address, map_.first_address(surface)) << map_.name(surface);
        ASSERT_LE(address + bytes, map_.first_address(surface) + map_.address_bytes(surface))
            << map_.name(surface);
        for (std::uint64_t b = address; b < address + bytes; ++b) {
            std::uint8_t& byte = owner_[static_cast<std::size_t>(partition)][b];
            ASSERT_EQ(byte, 0) << map_.name(surface) << " byte " << b;
            byte = static_cast<std::uint8_t>(surface + 1);
        }
    }

 private:
    const SurfaceMap& map_;
    std::vector<std::vector<std::uint8_t>> owner_;
};

TEST_P(Addresses, AreDisjointAndInsideTheirSurface) {
    const MapCase& c = GetParam();
    const TraceHeader header = plain_header(c.width, c.height);
    MachineConfig config = configured(c.settings);
    config.pool_bytes = 12 * 100 * config.partitions;
    const auto operation = operation_for(c.technique, header);
    const SurfaceMap map(operation->declaration(), config, header);
    Painter painter(map);
    const std::size_t tiles =
        static_cast<std::size_t>(tiles_across(c.width)) * static_cast<std::size_t>(tiles_across(c.height));
    for (int s = 0; s < map.surfaces(); ++s) {
        EXPECT_EQ(map.first_address(s) % config.cache.line_bytes, 0u);
        EXPECT_EQ(map.address_bytes(s) % config.cache.line_bytes, 0u);
        if (map.layout(s) == Layout::kPool) {
            for (int p = 0; p < map.partitions(); ++p)
                for (std::uint32_t n = 0; n < map.pool_nodes(); ++n)
                    painter.paint(p, s, map.node_address(s, n), map.element_bytes(s));
            continue;
        }
        const std::uint32_t elements = map.pixel_bytes(s) / map.element_bytes(s);
        for (std::size_t tile = 0; tile < tiles; ++tile)
            for (std::uint32_t quad = 0; quad < 16; ++quad)
                for (std::uint32_t pixel = 0; pixel < 4; ++pixel)
                    for (std::uint32_t e = 0; e < elements; ++e) {
                        const std::uint64_t address = map.address(s, tile, quad, pixel, e);
                        ASSERT_GE(address, map.tile_address(s, tile));
                        ASSERT_LE(address + map.element_bytes(s),
                                  map.tile_address(s, tile) + map.tile_bytes(s));
                        painter.paint(map.partition_of(tile), s, address, map.element_bytes(s));
                        if (HasFatalFailure()) return;
                    }
        // The depth and colour targets of a quad lie in one piece: they are read and written as such.
        if (s >= map.technique_surfaces()) {
            EXPECT_EQ(map.address(s, 0, 3, 3, 0), map.address(s, 0, 3, 0, 0) + 3 * map.pixel_bytes(s));
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Maps, Addresses,
    ::testing::Values(MapCase{"alpha_blend", {"rop.partitions=1"}, 20, 20},
                      MapCase{"adaptive:nodes=3", {"rop.partitions=3", "cache.line_bytes=64"}, 70, 41},
                      MapCase{
                          "laine_karras:samples=8", {"rop.partitions=4", "rop.partition_tiles=1"}, 65, 33},
                      MapCase{"stochastic:samples=5", {"rop.partitions=2", "cache.line_bytes=256"}, 40, 40},
                      MapCase{"slab:layers=3,bits=7", {"rop.partitions=6"}, 129, 25},
                      MapCase{"a_buffer", {"rop.partitions=64"}, 100, 100}));

// A surface of another kind in the same run would need another test; here each row of squares is shared out
// evenly.
TEST(Interleave, IsBalanced) {
    const auto operation = operation_for("alpha_blend", plain_header(1, 1));
    for (const int partitions : {1, 2, 3, 4, 6, 8, 16, 24, 32, 48, 64}) {
        for (const int side : {1, 2, 4}) {
            const TraceHeader header = plain_header(1280, 720);
            const SurfaceMap map(operation->declaration(),
                                 configured({"rop.partitions=" + std::to_string(partitions),
                                             "rop.partition_tiles=" + std::to_string(side)}),
                                 header);
            std::vector<int> tiles(static_cast<std::size_t>(partitions));
            for (std::size_t t = 0; t < 160 * 90; ++t) ++tiles[static_cast<std::size_t>(map.partition_of(t))];
            const auto [least, most] = std::minmax_element(tiles.begin(), tiles.end());
            // Neighbours along a row take turns, so a row of squares gives no partition more than one square
            // too many.
            const int rows = (90 + side - 1) / side;
            EXPECT_LE(*most - *least, rows * side * side) << partitions << " partitions of " << side;
            EXPECT_GT(*least, 0);
            // And with a power of two every partition has its turn down a column.
            if ((partitions & (partitions - 1)) != 0 || rows < partitions) continue;
            std::vector<int> seen(static_cast<std::size_t>(partitions));
            for (int row = 0; row < partitions; ++row)
                ++seen[static_cast<std::size_t>(
                    map.partition_of(static_cast<std::size_t>(row * side) * 160))];
            EXPECT_EQ(*std::min_element(seen.begin(), seen.end()), 1)
                << partitions << " partitions of " << side;
        }
    }
}

TEST(Memory, MustHoldTheSurfaces) {
    const TraceHeader header = plain_header(4096, 4096);
    const auto operation = operation_for("adaptive:nodes=64", header);
    EXPECT_THROW(
        SurfaceMap(operation->declaration(), configured({"rop.partitions=1", "dram.rows=1024"}), header),
        UserError);
}

// Random reads and writes of a quad against a map of bytes.
TEST(Collector, MergesAsAByteMapWould) {
    const TraceHeader header = plain_header(64, 64);
    const auto operation = operation_for("adaptive:nodes=8", header);
    std::mt19937 random(5);
    for (const auto& [line, sector] :
         {std::pair{64u, 8u}, {64u, 64u}, {128u, 32u}, {256u, 8u}, {256u, 256u}, {256u, 64u}}) {
        const MachineConfig config =
            configured({"cache.line_bytes=" + std::to_string(line),
                        "cache.sector_bytes=" + std::to_string(sector), "cache.request_queue=64"});
        const SurfaceMap map(operation->declaration(), config, header);
        LineCollector collector(map, config);
        QuadBatch batch;
        batch.lines.resize(1);
        batch.values.resize(1);
        std::vector<LineAccess>& lines = batch.lines[0];
        lines.resize(3);  // of earlier quads: not to be merged into
        for (int quad = 0; quad < 200; ++quad) {
            std::map<std::uint64_t, std::pair<std::vector<bool>, std::vector<bool>>>
                bytes;  // by line: read, written
            const std::size_t before = lines.size();
            collector.begin(batch, 0);
            for (int i = 0; i < 6; ++i) {
                const std::uint64_t address = random() % (8 * line);
                const std::uint32_t count = 1 + random() % (2 * line);
                const bool write = random() % 2 == 0;
                write ? collector.write(0, address, count, nullptr) : collector.read(0, address, count);
                for (std::uint64_t b = address; b < address + count; ++b) {
                    auto& [r, w] =
                        bytes.try_emplace(b / line * line, std::vector<bool>(line), std::vector<bool>(line))
                            .first->second;
                    (write ? w : r)[b % line] = true;
                }
            }
            ASSERT_EQ(collector.count(), bytes.size());
            for (std::size_t l = before; l < lines.size(); ++l) {
                const LineAccess& access = lines[l];
                ASSERT_TRUE(bytes.contains(access.line_address));
                const auto& [r, w] = bytes[access.line_address];
                for (std::uint32_t b = 0; b < line; ++b) {
                    EXPECT_EQ((access.write_bytes.word[b / 64] >> (b % 64) & 1) != 0, w[b]);
                    EXPECT_TRUE(!r[b] || (access.read_sectors >> (b / sector) & 1) != 0);
                }
                for (std::uint32_t s = 0; s < line / sector; ++s)
                    if (access.read_sectors >> s & 1) {
                        EXPECT_TRUE(std::any_of(r.begin() + s * sector, r.begin() + (s + 1) * sector,
                                                [](bool x) { return x; }));
                    }
                EXPECT_EQ(std::uint64_t{access.read_sectors} >> (line / sector), 0u);
            }
        }
    }
}

// What elements() collects is what address() says, element by element: the bytes written and the sectors
// read.
void expect_elements(const SurfaceMap& map, const MachineConfig& config, int surface, const char* technique) {
    const std::uint32_t elements = map.pixel_bytes(surface) / map.element_bytes(surface);
    const std::uint64_t all = all_elements(static_cast<int>(elements));
    std::mt19937_64 random(7);
    LineCollector collector(map, config);
    for (std::uint32_t pixel = 0; pixel < 64; ++pixel) {
        const SurfaceAccess access{random() & all, random() & all};
        QuadBatch batch;
        batch.lines.resize(1);
        batch.values.resize(1);
        collector.begin(batch, 0);
        collector.elements(surface, 9, pixel / 4, pixel % 4, access, nullptr);
        std::set<std::uint64_t> written;
        std::set<std::uint64_t> read;
        for (const LineAccess& l : batch.lines[0]) {
            EXPECT_TRUE(l.read_sectors != 0 || l.write_bytes.any());
            for (std::uint32_t b = 0; b < config.cache.line_bytes; ++b)
                if (l.write_bytes.word[b / 64] >> (b % 64) & 1) written.insert(l.line_address + b);
            for (std::uint32_t b = 0; b < config.cache.line_bytes; b += config.cache.sector_bytes)
                if (l.read_sectors >> (b / config.cache.sector_bytes) & 1) read.insert(l.line_address + b);
        }
        std::set<std::uint64_t> expected_written;
        std::set<std::uint64_t> expected_read;
        for (std::uint32_t e = 0; e < elements; ++e) {
            for (std::uint32_t b = 0; b < map.element_bytes(surface); ++b) {
                const std::uint64_t address = map.address(surface, 9, pixel / 4, pixel % 4, e) + b;
                if (access.write >> e & 1) expected_written.insert(address);
                if (access.read >> e & 1) expected_read.insert(address & ~(config.cache.sector_bytes - 1ull));
            }
        }
        EXPECT_EQ(written, expected_written) << technique << " " << map.name(surface) << " " << pixel;
        EXPECT_EQ(read, expected_read) << technique << " " << map.name(surface) << " " << pixel;
    }
}

TEST(Collector, CollectsTheElementsOfAPixel) {
    const TraceHeader header = plain_header(64, 64);
    for (const char* technique : {"alpha_blend", "adaptive:nodes=3", "adaptive:nodes=8", "adaptive:nodes=16",
                                  "adaptive:nodes=8,layout=planar", "weighted_blended",
                                  "laine_karras:samples=8", "stochastic:samples=8"}) {
        const auto operation = operation_for(technique, header);
        for (const auto& [line, sector] : {std::pair{64, 8}, {128, 32}, {256, 256}}) {
            const MachineConfig config =
                configured({fmt::format("cache.line_bytes={}", line),
                            fmt::format("cache.sector_bytes={}", sector), "cache.request_queue=64"});
            const SurfaceMap map(operation->declaration(), config, header);
            for (int s = 0; s < map.technique_surfaces(); ++s) expect_elements(map, config, s, technique);
        }
    }
}

}  // namespace
}  // namespace ropsim
