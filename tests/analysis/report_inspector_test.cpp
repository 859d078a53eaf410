// The inspector's pixels: which are chosen, and what is said of them, against the trace itself.
#include "analysis/report/report_inspector.h"

#include "base/error.h"
#include "model/run.h"
#include "rop/reference.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

Fragment fragment(float z, float a, float r, int x, int y, std::uint32_t primitive) {
    return {z,         r, 0.5f * r, 0, a, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
            primitive, 1, 0};
}

// Two overlapping fragments at (3, 1), given far one first.
PixelFragments two_fragments() {
    return {3,
            1,
            {fragment(0.75f, 0.5f, 0.25f, 3, 1, 0), fragment(0.25f, 0.25f, 0.125f, 3, 1, 1)},
            std::vector<DepthSlope>(2),
            0};
}

TraceHeader small_header() {
    TraceHeader header;
    header.width = 16;
    header.height = 8;
    header.background = glm::vec3(0.5f);
    header.draws.push_back({"draw"});
    return header;
}

TEST(StoredState, BlendingHasTheColourOfArrivalOrder) {
    const TraceHeader header = small_header();
    PixelRun run(header, two_fragments(), "alpha_blend:format=float32", 0);
    const auto surfaces = run.stored();
    ASSERT_EQ(surfaces.size(), 1u);
    EXPECT_EQ(surfaces[0].elements, 1);
    ASSERT_EQ(surfaces[0].changed.size(), 1u);
    // The background under alpha 0.5, under alpha 0.25: (0.5 * 0.5 + 0.25) * 0.75 + 0.125, green half of
    // that.
    EXPECT_THAT(surfaces[0].changed[0].values[0], testing::StartsWith("0.5  0.34375  0.1875"));
}

TEST(StoredState, NodesOfAPoolAreListedInArrivalOrder) {
    const TraceHeader header = small_header();
    PixelRun run(header, two_fragments(), "a_buffer:format=float32", 0);
    bool found = false;
    for (const StoredSurface& surface : run.stored()) {
        if (surface.changed.size() != 2) continue;
        found = true;
        EXPECT_EQ(surface.elements, 2);
        EXPECT_EQ(surface.changed[0].element, 0);
        const auto text = [&](std::size_t i) { return Json(surface.changed[i].values).dump(); };
        EXPECT_THAT(text(0), HasSubstr("0.75"));
        EXPECT_THAT(text(1), HasSubstr("0.25"));
        EXPECT_THAT(text(1), HasSubstr("0.125"));
    }
    EXPECT_TRUE(found);
}

TEST(StoredState, OnlyWrittenElementsAreListed) {
    const TraceHeader header = small_header();
    PixelRun run(header, two_fragments(), "k_buffer:layers=4,format=float32", 0);
    std::size_t most = 0;
    for (const StoredSurface& surface : run.stored())
        if (surface.elements == 4) most = std::max(most, surface.changed.size());
    EXPECT_EQ(most, 2u) << "two fragments, two of four layers";
}

TEST(StoredState, IsNotToldOfMoreThanThePixel) {
    TraceHeader header = small_header();
    Declaration declaration;
    EXPECT_EQ(PixelRun::beyond_one_pixel(declaration, header), "");
    declaration.shades_materials = true;
    EXPECT_EQ(PixelRun::beyond_one_pixel(declaration, header), "");
    header.materials = true;
    EXPECT_THAT(PixelRun::beyond_one_pixel(declaration, header), HasSubstr("materials"));
    Declaration low;
    low.passes.push_back({"half"});
    low.passes.back().scale = 2;
    EXPECT_THAT(PixelRun::beyond_one_pixel(low, header), HasSubstr("lower resolution"));
    Declaration gathering;
    gathering.passes.push_back({"blur"});
    gathering.passes.back().gathers = true;
    EXPECT_THAT(PixelRun::beyond_one_pixel(gathering, header), HasSubstr("around"));
}

TEST(PixelPlaces, AreParsed) {
    EXPECT_EQ(parse_pixel_place("12,7", "--inspect"), (PixelPlace{12, 7}));
    for (const char* text : {"", "1", "1,", ",1", "-1,2", "1,2,3", "a,b", "1, 2"})
        EXPECT_THROW(parse_pixel_place(text, "--inspect"), UserError) << text;
}

Image flat(int width, int height, float value) {
    Image image(width, height, {"R", "G", "B", "layers"});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            std::fill_n(image.pixel(x, y), 3, value);
            image.pixel(x, y)[3] = x < width / 2 ? 1.0f : 0.0f;  // the left half is covered
        }
    return image;
}

TEST(ChosenPixels, TheTellingOnesFirstAndOnlyCoveredOnes) {
    Image reference = flat(200, 100, 0.5f);
    reference.pixel(40, 20)[3] = 9;
    reference.pixel(41, 21)[3] = 8;  // too near
    reference.pixel(80, 90)[3] = 7;
    Image image = flat(200, 100, 0.5f);
    image.pixel(60, 60)[1] = 0.9f;
    image.pixel(150, 50)[1] = 0;  // worse, but nothing transparent is there
    const auto pixels = chosen_pixels(reference, {{"blend", 0, &image}}, {{150, 2}});
    EXPECT_EQ(pixels[0].place, (PixelPlace{150, 2}));
    EXPECT_EQ(pixels[0].why, "asked for");
    EXPECT_EQ(pixels[1].place, (PixelPlace{40, 20}));
    EXPECT_EQ(pixels[2].place, (PixelPlace{80, 90}));
    std::set<PixelPlace> places;
    bool worst = false;
    for (const ChosenPixel& pixel : pixels) {
        EXPECT_TRUE(places.insert(pixel.place).second) << "twice";
        if (pixel.why != "asked for") {
            EXPECT_LT(pixel.place.x, 100) << pixel.why;
        }
        if (pixel.place == PixelPlace{60, 60}) {
            worst = true;
            EXPECT_EQ(pixel.why, "where blend errs most");
        }
    }
    EXPECT_TRUE(worst);
    EXPECT_GT(pixels.size(), 50u) << "a grid";
}

class InspectorData : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        RandomFragments options;
        options.width = 24;
        options.height = 16;
        options.count = 4000;
        options.alpha_low = 0.05f;
        options.alpha_high = 0.9f;
        trace_ = path("random.trace");
        fragments_ = random_fragments(options);
        write_trace(trace_, random_header(options), fragments_);
        TraceReader trace(trace_);
        reference_ = reference_image(trace, 1);
        RunOptions run;
        run.trace = trace_;
        run.technique = "adaptive:nodes=4";
        run.fidelity = Fidelity::kCount;
        run.threads = 1;
        image_ = run_simulation(run).image;
    }
    std::vector<InspectedRun> runs() const {
        return {{"adaptive:nodes=4", 0, &image_}, {"weighted_blended", 0, &image_}};
    }
    std::string trace_;
    std::vector<Fragment> fragments_;
    Image reference_, image_;
};

TEST_F(InspectorData, FragmentsVisibilityAndColoursAreThoseOfTheTrace) {
    const std::vector<ChosenPixel> pixels{{{7, 3}, "asked for"}, {{20, 11}, "on the grid"}};
    const auto data = inspector_data("px", trace_, reference_, runs(), pixels, 1, 1'000'000, 2);
    ASSERT_EQ(data.size(), 3u);
    EXPECT_EQ(Json::parse(data.back().text)["pixels"].size(), 2u);
    for (std::size_t p = 0; p < 2; ++p) {
        const Json json = Json::parse(data[p].text);
        const PixelPlace place = pixels[p].place;
        std::vector<Fragment> here;
        for (const Fragment& f : fragments_)
            if (f.x == place.x && f.y == place.y) here.push_back(f);
        ASSERT_EQ(json["count"], here.size());
        std::vector<float> depths;
        for (const Json& entry : json["fragments"]) {
            const Fragment& f = here[entry[0].get<std::size_t>() - 1];
            EXPECT_EQ(entry[1].get<float>(), f.z);
            EXPECT_NEAR(entry[2].get<double>(), static_cast<double>(f.a), 1e-4);
            depths.push_back(f.z);
        }
        EXPECT_TRUE(std::is_sorted(depths.begin(), depths.end()));
        for (std::size_t i = 0; i < json["depths"].size(); ++i) {
            double exact = 1;
            for (const Fragment& f : here)
                if (f.z < json["depths"][i].get<float>()) exact *= 1 - static_cast<double>(f.a);
            EXPECT_NEAR(json["exact"][i].get<double>() * 1e-4, exact, 6e-5);
        }
        const Json& adaptive = json["techniques"][0];
        EXPECT_NEAR(adaptive["color"][0].get<double>(),
                    static_cast<double>(image_.pixel(place.x, place.y)[image_.channel("R")]), 1e-4);
        EXPECT_EQ(adaptive["visibility"].size(), json["depths"].size());
        EXPECT_FALSE(adaptive["surfaces"].empty());
        EXPECT_FALSE(json["techniques"][1].contains("visibility")) << "weights are no visibility";
    }
}

TEST_F(InspectorData, KeepsItsBudgetButNotForWhatWasAskedFor) {
    const std::vector<ChosenPixel> pixels{{{7, 3}, "asked for"}, {{20, 11}, "grid"}, {{2, 2}, "grid"}};
    const auto all = inspector_data("px", trace_, reference_, runs(), pixels, 1, 1'000'000, 1);
    ASSERT_EQ(all.size(), 4u);
    EXPECT_EQ(inspector_data("px", trace_, reference_, runs(), pixels, 1, 1, 1).size(), 2u);
    const std::size_t two = all[0].text.size() + all[1].text.size();
    EXPECT_LE(inspector_data("px", trace_, reference_, runs(), pixels, 1, two, 1).size(), 3u);
}

}  // namespace
}  // namespace ropsim
