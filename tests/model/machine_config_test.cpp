// Hardware presets, files and settings: what is read, what is refused and where.
#include "tests/model/machine_driver.h"

#include <gmock/gmock.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;
using MachineConfigTest = ModelTest;

// "where: what" of the refusal, or "" when there is none.
std::string refusal(const std::string& preset_or_file, const Settings& settings = {}) {
    try {
        Parameters parameters = hardware_parameters(preset_or_file);
        for (const std::string& s : settings) set_from_text(parameters, s, "--set");
        machine_config(parameters, preset_or_file);
        parameters.close();
    } catch (const UserError& error) {
        return error.where() + ": " + error.what();
    }
    return "";
}

TEST(MachineConfigPresets, ParseAndHoldNoUnknownKey) {
    ASSERT_GE(hardware_presets().size(), 2u);
    for (const HardwarePreset& preset : hardware_presets()) {
        EXPECT_EQ(refusal(preset.name), "");
        EXPECT_GT(preset.summary.size(), 20u);
        EXPECT_EQ(preset.summary.find('\n'), std::string::npos);
    }
}

TEST(MachineConfigPresets, DesktopIsWhatItsFileSays) {
    Parameters parameters = hardware_parameters("desktop");
    const MachineConfig c = machine_config(parameters, "desktop");
    EXPECT_EQ(c.rop_period_ps, 667u);
    EXPECT_EQ(c.partitions, 8u);
    EXPECT_EQ(c.cache.size_bytes, 16384u);
    EXPECT_EQ(c.cache.line_bytes, 128u);
    EXPECT_EQ(c.pool_bytes, 256u << 20);
    EXPECT_EQ(c.hazards.interlock, HazardConfig::Interlock::kQuad);
    EXPECT_EQ(c.dram.device, "gddr6");
}

TEST(MachineConfigPresets, SettingsReplaceValues) {
    const MachineConfig c =
        configured({"rop.partitions=3", "rop.interlock=pixel", "cache.fast_clear=false", "clock.rop_mhz=1000",
                    "rop.adders=2", "datapath.latency.divider=31", "dram.device=hbm2", "rop.partitions=4"});
    EXPECT_EQ(c.partitions, 4u);  // the last one holds
    EXPECT_EQ(c.hazards.interlock, HazardConfig::Interlock::kPixel);
    EXPECT_FALSE(c.fast_clear);
    EXPECT_EQ(c.rop_period_ps, 1000u);
    EXPECT_EQ(c.datapath.budget[static_cast<std::size_t>(Unit::kAdder)], 2);
    EXPECT_EQ(c.datapath.latency[static_cast<std::size_t>(Unit::kDivider)], 31);
    EXPECT_EQ(c.dram.device, "hbm2");
}

TEST(MachineConfigPresets, RefusesUnknownNamesKeysAndForms) {
    EXPECT_THAT(refusal("desctop"), HasSubstr("unknown preset 'desctop'; choose one of "));
    EXPECT_THAT(refusal("desctop"), HasSubstr("desktop, "));
    EXPECT_THAT(refusal("desktop", {"rop.partition=3"}), HasSubstr("rop.partitions"));
    EXPECT_THAT(refusal("desktop", {"rop.partitions"}), HasSubstr("'rop.partitions' is not key=value"));
    EXPECT_THAT(refusal("desktop", {"=3"}), HasSubstr("is not key=value"));
    EXPECT_THAT(refusal("desktop", {"rop.partitions=many"}), HasSubstr("--set: rop.partitions=many"));
    EXPECT_THAT(refusal("desktop", {"rop.interlock=line"}), HasSubstr("pixel, quad, tile"));
    EXPECT_THAT(refusal("no/such/file.toml"), HasSubstr("no/such/file.toml"));
    EXPECT_THAT(refusal("desktop", {"dram.device=ddr9"}), HasSubstr("ddr9"));
}

TEST(MachineConfigPresets, RefusesValuesOutOfRange) {
    for (const char* setting :
         {"rop.partitions=0", "rop.partitions=65", "rop.quads_in_flight=33", "rop.input_queue=0",
          "clock.rop_mhz=5", "clock.rop_mhz=nan", "cache.kibibytes=0", "cache.ways=-1",
          "cache.line_bytes=512", "cache.sector_bytes=4", "cache.request_queue=8", "shader.alu_lanes=0",
          "rop.adders=-1", "datapath.latency.mux=1001", "pool.mebibytes=0", "rop.lanes=1.5"})
        EXPECT_NE(refusal("desktop", {setting}), "") << setting;
    // Sizes that do not fit together, whatever is simulated.
    for (const char* setting :
         {"cache.line_bytes=100", "cache.sector_bytes=256", "cache.sector_bytes=24", "cache.ways=3"})
        EXPECT_THAT(refusal("desktop", {setting}), HasSubstr("cache.")) << setting;
    // Thirty-two sectors a line can need as many requests at once.
    EXPECT_THAT(refusal("desktop", {"cache.line_bytes=256", "cache.sector_bytes=8"}),
                HasSubstr("request_queue"));
    EXPECT_EQ(refusal("desktop", {"cache.line_bytes=256", "cache.sector_bytes=8", "cache.request_queue=32"}),
              "");
}

TEST(MachineConfigPresets, SeparateCachesShareTheWhole) {
    const MachineConfig halves = configured({"cache.organisation=separate"});
    EXPECT_EQ(halves.cache.section_bytes, (std::array<std::uint32_t, 3>{8192, 8192, 0}));
    const MachineConfig thirds =
        configured({"cache.organisation=separate", "cache.depth_kibibytes=4", "cache.node_kibibytes=6"});
    EXPECT_EQ(thirds.cache.section_bytes, (std::array<std::uint32_t, 3>{4096, 6144, 6144}));
    EXPECT_EQ(thirds.cache.size_bytes, 16384u);
    EXPECT_THAT(
        refusal("desktop",
                {"cache.organisation=separate", "cache.depth_kibibytes=12", "cache.color_kibibytes=8"}),
        HasSubstr("--set: cache.depth_kibibytes=12: 12 KiB for depth, 8 for colour and 0 for nodes must "
                  "make cache.kibibytes = 16"));
    EXPECT_THAT(refusal("desktop", {"cache.organisation=separate", "cache.node_kibibytes=8"}),
                HasSubstr("cache.kibibytes = 16"));
    // A key that only separate caches have means nothing to a shared one.
    EXPECT_THAT(refusal("desktop", {"cache.depth_kibibytes=4"}), HasSubstr("no such key"));
    EXPECT_THAT(refusal("desktop", {"cache.organisation=split"}), HasSubstr("shared, separate"));
    EXPECT_THAT(refusal("desktop", {"cache.organisation=separate", "cache.ways=16", "cache.line_bytes=256",
                                    "cache.kibibytes=24", "cache.depth_kibibytes=10"}),
                HasSubstr("a section of 10240 bytes"));
}

TEST(MachineConfigPresets, L2SlicesAreCheckedWhereThereAreAny) {
    const MachineConfig c = configured({"l2.kibibytes=64", "l2.latency=7"});
    EXPECT_TRUE(c.l2.present());
    EXPECT_EQ(c.l2.cache.size_bytes, 65536u);
    EXPECT_EQ(c.l2.latency, 7u);
    EXPECT_FALSE(configured({"l2.latency=7"}).l2.present());
    EXPECT_THAT(refusal("desktop", {"l2.kibibytes=64", "l2.ways=24"}),
                HasSubstr("l2.kibibytes=64: size_bytes"));
    EXPECT_THAT(refusal("desktop", {"l2.kibibytes=64", "l2.line_bytes=256", "l2.sector_bytes=8"}),
                HasSubstr("l2.request_queue: must be at least 32"));
    for (const char* setting : {"l2.kibibytes=-1", "l2.ways=0", "l2.bytes_per_cycle=0", "l2.flush=maybe",
                                "cache.ports=0", "cache.port_bytes=-1", "l2.size=3"})
        EXPECT_NE(refusal("desktop", {setting}), "") << setting;
}

TEST(MachineConfigPresets, PresetsAreWhatTheirSourcesSay) {
    const auto preset = [](const char* name) {
        Parameters parameters = hardware_parameters(name);
        return machine_config(parameters, name);
    };
    const MachineConfig attila = preset("attila");
    EXPECT_EQ(attila.cache.section_bytes, (std::array<std::uint32_t, 3>{16384, 16384, 0}));
    EXPECT_EQ(attila.port_cycles(attila.cache.line_bytes), 8u);
    // Eight channels of eight bytes a cycle of 500 MHz.
    EXPECT_NEAR(attila.partitions * attila.dram.peak_bytes_per_second(), 8 * 8 * 500e6, 1e6);
    const MachineConfig fermi = preset("fermi");
    EXPECT_EQ(fermi.partitions * fermi.cache.size_bytes, 768u << 10);
    EXPECT_EQ(fermi.partitions * fermi.lanes, 48u);
    EXPECT_FALSE(fermi.l2.present());
    EXPECT_NEAR(fermi.partitions * fermi.dram.peak_bytes_per_second(), 177.4e9, 0.2e9);  // GeForce GTX 480
    EXPECT_EQ(fermi.partitions * fermi.dram.capacity_bytes(), std::uint64_t{1536} << 20);
    const MachineConfig rdna = preset("rdna");
    EXPECT_EQ(rdna.partitions * rdna.l2.cache.size_bytes, 4u << 20);
    EXPECT_EQ(rdna.partitions * rdna.lanes, 64u);
    EXPECT_NEAR(rdna.partitions * rdna.dram.peak_bytes_per_second(), 448e9, 2e9);  // Radeon RX 5700 XT
}

TEST_F(MachineConfigTest, FilesAreRefusedWithFileAndLine) {
    write_file(path("a.toml"), "# mine\n[rop]\npartitions = 2\nlanez = 4\n");
    EXPECT_THAT(refusal(path("a.toml")), HasSubstr("a.toml:4: rop.lanez"));
    EXPECT_THAT(refusal(path("a.toml")), HasSubstr("rop.lanes"));
    write_file(path("b.toml"), "[rop]\n\npartitions = 99\n");
    EXPECT_THAT(refusal(path("b.toml")), HasSubstr("b.toml:3: rop.partitions=99"));
    write_file(path("c.toml"), "[rop]\npartitions = = 2\n");
    EXPECT_THAT(refusal(path("c.toml")), HasSubstr("c.toml:2"));
    write_file(path("d.toml"), "[rop]\npartitions = 2\n[dram]\ndevice = \"hbm2\"\n");
    EXPECT_EQ(refusal(path("d.toml")), "");
    EXPECT_EQ(refusal(path("d.toml"), {"rop.lanes=2"}), "");
}

}  // namespace
}  // namespace ropsim
