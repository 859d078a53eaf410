// The picture of a convergence study.
#include "analysis/convergence_plot.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/scratch.h"

#include <cmath>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

namespace ropsim {
namespace {

using testing::HasSubstr;
using testing::Not;

// Two techniques with errors 20 S^-1/2 and 20/S, two seeds a little to both sides.
Convergence study_of(const std::string& trace) {
    Convergence study;
    study.options.trace = trace;
    study.options.seeds = 2;
    study.width = 64;
    study.height = 48;
    for (const double slope : {-0.5, -1.0}) {
        ConvergenceOfTechnique technique;
        technique.technique = slope == -1 ? "laine_karras" : "stochastic:format=float32";
        technique.random = true;
        std::vector<Replicates> errors;
        for (const double s : {4, 8, 16}) {
            const double error = 20 * std::pow(s, slope);
            ConvergenceAtValue at;
            at.text = fmt::format("{}", s);
            at.value = s;
            for (const double factor : {0.8, 1.25}) at.runs.push_back({1, error * factor, 0, 0, 0, 0});
            errors.push_back({s, at.all(&ConvergenceRun::rmse8)});
            technique.values.push_back(at);
        }
        technique.fit = fit_power_law("samples", errors);
        study.techniques.push_back(technique);
    }
    return study;
}

struct Picture {
    unsigned width = 0;
    unsigned height = 0;
    std::vector<unsigned char> rgb;

    long count(int r, int g, int b) const {
        long n = 0;
        for (std::size_t i = 0; i < rgb.size(); i += 3)
            n += rgb[i] == r && rgb[i + 1] == g && rgb[i + 2] == b;
        return n;
    }
};

Picture decoded(const std::string& path) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_file(&png, path.c_str()), 0) << png.message;
    png.format = PNG_FORMAT_RGB;
    Picture picture{png.width, png.height, std::vector<unsigned char>(PNG_IMAGE_SIZE(png))};
    EXPECT_NE(png_image_finish_read(&png, nullptr, picture.rgb.data(), 0, nullptr), 0) << png.message;
    return picture;
}

class ConvergencePlot : public ScratchTest {};

TEST_F(ConvergencePlot, BothPicturesAreDrawn) {
    // A name that gnuplot would take for a command or for the end of a text.
    const Convergence study = study_of("/t/it's `touch owned`.trace");
    write_convergence_plot(study, path(""));
    EXPECT_EQ(entries(), 2u);  // no script, no temporary
    const Picture png = decoded(path("convergence.png"));
    EXPECT_EQ(png.width, 1800u);
    EXPECT_GT(png.count(255, 255, 255), static_cast<long>(png.width) * png.height / 2);
    EXPECT_GT(png.count(0x00, 0x72, 0xB2), 1000);  // each technique's line, markers and legend
    EXPECT_GT(png.count(0xD5, 0x5E, 0x00), 1000);
    const std::string svg = read_file(path("convergence.svg"));
    for (const char* text :
         {"it's `touch owned`: error against samples", "64\u00d748 pixels", "2 seeds",
          "stored samples S a pixel", "RMSE over all pixels, 8-bit units",
          "stochastic:format=float32:  slope \u22120.500 \u00b1 0.",
          "laine_karras:  slope \u22121.000 \u00b1 0.", "slope \u2212\u00bd", "slope \u22121", "</svg>"})
        EXPECT_THAT(svg,
                    testing::AnyOf(HasSubstr(text), HasSubstr(std::string(text).replace(2, 1, "&#39;"))));
}

TEST_F(ConvergencePlot, ShowsMeansBarsAndLaws) {
    const std::string script = convergence_plot_script(study_of("a.trace"), "a.svg", "a.png");
    // Mean of 8 and 12.5, and one standard deviation, 4.5/sqrt(2), to both sides.
    EXPECT_THAT(script, HasSubstr("4 10.25 7.06801"));
    EXPECT_THAT(script, HasSubstr(" 13.43198"));
    // The law goes through the geometric mean of both seeds.
    EXPECT_THAT(script, testing::ContainsRegex(
                            "law_0 << EOD\n4 (10\\.0000|9\\.9999)[0-9]*\n16 (5\\.0000|4\\.9999|5\n)"));
    EXPECT_THAT(script, HasSubstr("set logscale xy"));
}

TEST_F(ConvergencePlot, ErrorsOfZeroHaveNoPlace) {
    Convergence study = study_of("a.trace");
    EXPECT_TRUE(has_plot(study));
    for (ConvergenceRun& run : study.techniques[1].values[1].runs) run.rmse8 = 0;
    study.techniques[1].fit = {{}, "the error is 0 at samples=8, which has no logarithm"};
    const std::string script = convergence_plot_script(study, "a.svg", "a.png");
    EXPECT_THAT(script, Not(HasSubstr("$law_1")));
    EXPECT_THAT(script, HasSubstr("laine_karras:  no slope, the error is 0"));
    EXPECT_THAT(script, Not(HasSubstr("\n8 0 ")));
    write_convergence_plot(study, path(""));
    EXPECT_GT(decoded(path("convergence.png")).count(0xD5, 0x5E, 0x00), 100);  // its markers
    for (ConvergenceOfTechnique& technique : study.techniques)
        for (ConvergenceAtValue& at : technique.values)
            for (ConvergenceRun& run : at.runs) run.rmse8 = 0;
    EXPECT_FALSE(has_plot(study));
}

TEST_F(ConvergencePlot, AMissingGnuplotIsNamed) {
    const std::string before = std::getenv("PATH");
    ASSERT_EQ(setenv("PATH", path("").c_str(), 1), 0);
    try {
        gnuplot_program();
        ADD_FAILURE() << "found";
    } catch (const UserError& error) {
        EXPECT_THAT(error.what(), HasSubstr("gnuplot-nox"));
    }
    // One that fails leaves nothing.
    write_file(path("gnuplot"), "#!/bin/sh\necho 'no font' >&2\nexit 1\n");
    std::filesystem::permissions(path("gnuplot"), std::filesystem::perms::owner_all);
    try {
        write_convergence_plot(study_of("a.trace"), path(""));
        ADD_FAILURE() << "drawn";
    } catch (const UserError& error) {
        EXPECT_THAT(error.what(), HasSubstr("no font"));
    }
    EXPECT_EQ(entries(), 1u);
    ASSERT_EQ(setenv("PATH", before.c_str(), 1), 0);
}

}  // namespace
}  // namespace ropsim
