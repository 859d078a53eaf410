// Claims of McGuire and Mara 2017 that can be computed: equations against listings, precision of the targets,
// arithmetic of Table 1.
#include "analysis/claims/phenomenological.h"
#include "rop/format.h"
#include "rop/phenomenological/surface_shader.h"
#include "rop/registry.h"
#include "rop/shadow/caustics.h"

#include <array>
#include <cmath>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

// The paper's view: 1920x1080, 60 degrees; 1 unit is a metre.
Camera camera_of_paper() {
    Camera camera;
    camera.near_plane = 0.1f;
    camera.far_plane = 200;
    camera.fovy_degrees = 60;
    camera.projection = glm::perspective(glm::radians(60.0f), 1920.0f / 1080, 0.1f, 200.0f);
    return camera;
}
SurfaceShader shader_of(const std::string& keys) {
    Screen screen{1920, 1080};
    screen.camera = camera_of_paper();
    screen.materials = true;
    TechniqueSpec spec = parse_technique("phenomenological" + keys, "technique");
    const PhenomenologicalOptions options(spec.parameters, screen);
    return {options, spec.parameters, screen};
}
// Window depth of what is so many metres away.
float depth_at(double metres) {
    const glm::dmat4 p(camera_of_paper().projection);
    return static_cast<float>(0.5 * ((p[2][2] * -metres + p[3][2]) / (p[2][3] * -metres + p[3][3]) + 1));
}

// What is left of the background behind an opaque surface.
double behind_opaque(const std::string& keys) {
    Fragment f{};
    f.z = 0.5f;
    f.a = 1;
    f.coverage = 1;
    const Material opaque{};
    return 1 -
           static_cast<double>(shader_of(keys).shade({f, opaque, 960, 540, 1.0f})[surface_export::kAbsorbed]);
}

using Found = std::vector<Reading>;

void add_row(std::vector<Claim>& claims, const char* id, const char* place, const char* claim,
             Printed printed, Rule rule, const char* how, const std::string& why,
             std::vector<Reading> (*find)()) {
    claims.push_back({id, kPhenomenologicalPaper, place, claim, std::move(printed), rule, Basis::kDefinition,
                      how, false, [find, why](ClaimRuns&) {
                          const std::vector<Reading> readings = find();
                          return Finding{{}, readings.front().values, readings, why};
                      }});
}

void add_contradictions(std::vector<Claim>& claims) {
    const char* how = "the technique's own shader";
    add_row(claims, "mm-beta-third", "equation 2, listing 1",
            "An opaque surface lets nothing through: what is left of the background",
            Printed::meaning("beta is exact", 0, 1e-6), rule::digits(), how,
            "Listing 1 multiplies by 1/3 besides, so that two thirds of the background stay", [] {
                return Found{{"", {behind_opaque(":beta=third")}},
                             {"equation 2, without Listing 1's factor of 1/3", {behind_opaque("")}}};
            });
    add_row(
        claims, "mm-eq9", "equation 9",
        "A surface of index 1 bends nothing: displacement at 45 degrees, pixels, by the equation as the text "
        "at hand has it",
        Printed::meaning("by Snell's law: 0", 0, 0.01), rule::digits(), how,
        "eta - n w + sqrt(k) as the text at hand has it; Snell's law has eta n w - sqrt(k)", [] {
            const auto pixels = [](const char* keys) {
                const glm::vec2 d = shader_of(keys).displacement(960, 540, depth_at(3),
                                                                 glm::normalize(glm::vec3(1, 0, 1)), 1);
                return static_cast<double>(std::hypot(d.x, d.y));
            };
            return Found{{"", {pixels(":refraction=printed")}},
                         {"Snell's law in equation 9's place", {pixels("")}}};
        });
    add_row(claims, "mm-k1", "section 4.3.1, listing 1",
            "Implied thickness k1 of a scattering surface, metres, of all scenes", Printed::numbers_of("0.5"),
            rule::exact(), "Listing 1's constant",
            "the listing has .05; with the text's .5 a hand on the glass is sharp, see mm-hand", [] {
                return Found{{"", {0.05}}};
            });
    add_row(claims, "mm-hand", "section 4.3.1",
            "A hand pressed against frosted glass appears sharp: deviation 2 cm behind a pane at 1 m, over "
            "that of what is far behind",
            Printed::meaning("sharp: taken as at most a tenth of the far blur", 0.1, 0), rule::at_most(), how,
            "gap over k1 and gap: .02 / .52 with the text's .5, .02 / .07 with Listing 1's .05", [] {
                const auto share = [](const char* keys) {
                    const SurfaceShader shader = shader_of(keys);
                    const float pane = depth_at(1);
                    return static_cast<double>(shader.deviation(pane, depth_at(1.02), 0, 1)) /
                           static_cast<double>(shader.deviation(pane, 1.0f, 0, 1));
                };
                return Found{{"", {share("")}}, {"Listing 1's k1", {share(":k1=0.05")}}};
            });
    add_row(claims, "mm-clear-frosted", "equations 6, 7, listing 1",
            "Clear frosted glass (t = 1, c = 0) scatters: its deviation over that of opaque coverage",
            Printed::meaning("by alpha: 1", 1, 1e-6), rule::digits(), how,
            "Listing 1 weights by net coverage, which is 0 for clear glass: no diffusion at all", [] {
                const SurfaceShader shader = shader_of("");
                const float pane = depth_at(1);
                const auto deviation = [&](float covered) {
                    return static_cast<double>(shader.deviation(pane, 1.0f, 0, covered));
                };
                return Found{{"Listing 1's net coverage", {deviation(0) / deviation(1)}},
                             {"alpha, as equations 6 and 7 have it", {deviation(1) / deviation(1)}}};
            });
}

// The deviation of n discrete Gaussians, convolved.
double convolved_deviation(int kernels, double deviation) {
    constexpr int kReach = 400;
    std::vector<double> sum{1};
    for (int k = 0; k < kernels; ++k) {
        std::vector<double> next(sum.size() + 2 * kReach / 4, 0.0);
        const int reach = kReach / 4;
        double total = 0;
        std::vector<double> kernel;
        for (int i = -reach; i <= reach; ++i) {
            kernel.push_back(std::exp(-0.5 * i * i / (deviation * deviation)));
            total += kernel.back();
        }
        for (std::size_t i = 0; i < sum.size(); ++i)
            for (std::size_t j = 0; j < kernel.size(); ++j) next[i + j] += sum[i] * kernel[j] / total;
        sum = std::move(next);
    }
    const double middle = static_cast<double>(sum.size() - 1) / 2;
    double variance = 0;
    for (std::size_t i = 0; i < sum.size(); ++i)
        variance += sum[i] * std::pow(static_cast<double>(i) - middle, 2);
    return std::sqrt(variance);
}

// D is the root of codes of D^2: around D they are unit / (2 D) apart.
std::string diffusion_precision() {
    const double unit = 63.0 * 63 * static_cast<double>(next_stored_above(Format::kUnorm8, 0.0f));
    return fmt::format(
        "the least D is {:.1f} pixels; codes are half a pixel apart from about {:.1f} pixels on",
        std::sqrt(unit), unit);
}

void add_diffusion(std::vector<Claim>& claims) {
    add_row(claims, "mm-deviations-add", "section 4.3.1, equation 6",
            "The deviation of the net kernel is the sum of the deviations: 4 equal Gaussians over one",
            Printed::meaning("the sum of the standard deviations", 4, 0.01), rule::digits(),
            "4 Gaussians of 9 pixels, convolved", "variances add, as equation 7 has it: 2", [] {
                return Found{{"", {convolved_deviation(4, 9) / convolved_deviation(1, 9)}}};
            });
    add_row(claims, "mm-half-pixel-refraction", "Table 2",
            "1/63 gives roughly half a pixel of precision on refraction", Printed::meaning("1/2", 0.5, 0.05),
            rule::digits(), "a code of RG8_SNORM times 63", "63/127", [] {
                const double code = static_cast<double>(next_stored_above(Format::kSnorm8, 0.0f));
                return Found{{"", {63 * code}}};
            });
    add_row(claims, "mm-half-pixel-diffusion", "Table 2",
            "1/63 gives roughly half a pixel of precision on diffusion", Printed::meaning("1/2", 0.5, 0.05),
            rule::digits(), "the root of a code of UNORM8 times 63, since D^2 is stored",
            diffusion_precision(), [] {
                const double code = static_cast<double>(next_stored_above(Format::kUnorm8, 0.0f));
                return Found{{"", {63 * std::sqrt(code)}}};
            });
}

// beta after so many layers of alpha, none of which transmits, as stored.
double stored_beta(Format format, float alpha, int layers) {
    float beta = 1;
    for (int i = 0; i < layers; ++i) beta = stored_value(format, beta * (1 - alpha));
    return static_cast<double>(beta);
}

void add_precision(std::vector<Claim>& claims) {
    add_row(claims, "mm-beta-exact", "section 5.0.4",
            "Modulation of the background as captured in beta is exact: 500 layers of alpha .01",
            Printed::meaning("exact: .99^500", std::pow(0.99, 500), 0.5 / 255), rule::digits(),
            "the product in the format of Table 2, and in float16; held to half a code of 8 bits",
            fmt::format("RGBA8 stalls at {:.0f}/255, where 1 % of beta is less than half a code",
                        255 * stored_beta(Format::kUnorm8, 0.01f, 500)),
            [] {
                return Found{{"", {stored_beta(Format::kUnorm8, 0.01f, 500)}},
                             {"beta in float16", {stored_beta(Format::kFloat16, 0.01f, 500)}},
                             {"beta in float32", {stored_beta(Format::kFloat32, 0.01f, 500)}}};
            });
    add_row(claims, "mm-weight", "equation 5", "w at z = .5 and net coverage .5, and its two bounds",
            Printed::formula("min(max((10 (1 - .99 z) net)^3, .01), 30)", {std::pow(2.525, 3), 0.01, 30}),
            rule::digits(), "the technique's own shader", "at (.5, .5); at (1, .5) and (0, 1) the bounds",
            [] {
                const SurfaceShader shader = shader_of("");
                return Found{
                    {"",
                     {static_cast<double>(shader.weight(0.5f, 0.5f)),
                      static_cast<double>(shader.weight(1, 0.5f)), static_cast<double>(shader.weight(0, 1))},
                     false,
                     1e-5}};
            });
    add_row(
        claims, "mm-caustics", "section 4.3.3",
        "Shadowing at normal incidence over that without caustics, glass: less, at grazing incidence more",
        Printed::statement("decrease shadowing ... at normal incidence"), rule::statement(),
        "equations 11 to 13 at index 1.5", "two sentences on the prose has it the other way round", [] {
            const CausticModel equations;
            const double normal = static_cast<double>(caustic_factor(equations, 1.5f, 1, false));
            const double grazing = static_cast<double>(caustic_factor(equations, 1.5f, 0, false));
            return Found{{"", {normal, grazing}, normal < 1 && grazing > 1}};
        });
    add_row(claims, "mm-caustics-prose", "section 4.3.3",
            "rho grows where the surface faces the light and falls at grazing incidence",
            Printed::statement("increase rho where ... is close to 1, and decrease ... close to zero"),
            rule::statement(), "equations 11 to 13 at index 1.5",
            "equations 12 and 13 do the opposite, as the section says first", [] {
                const CausticModel equations;
                const double normal = static_cast<double>(caustic_factor(equations, 1.5f, 1, false));
                const double grazing = static_cast<double>(caustic_factor(equations, 1.5f, 0, false));
                return Found{{"", {normal, grazing}, normal > 1 && grazing < 1}};
            });
}

void add_table1(std::vector<Claim>& claims) {
    const auto add = [&](const char* id, const char* claim, const char* printed, Rule rule,
                         const std::string& why, std::vector<double> values) {
        claims.push_back({id, kPhenomenologicalPaper, "section 7.3, Table 1", claim,
                          Printed::numbers_of(printed), rule, Basis::kDefinition,
                          "arithmetic on the printed milliseconds", false, [values, why](ClaimRuns&) {
                              return Finding{{}, values, {{"", values}}, why};
                          }});
    };
    add("mm-table1-vsm", "VSM creation depends on lights and wavelengths only: 3 over 1 wavelengths", "3",
        rule::digits(), "4.65 over 1.55 ms", {4.65 / 1.55});
    add("mm-table1-order",
        "Subsampling increases the OIT stage's throughput by more than an order of magnitude", "10, 10",
        rule::at_least(), "4.32 over .37 and 2.91 over .25 ms", {4.32 / 0.37, 2.91 / 0.25});
    add("mm-table1-upsampling", "Upsampling adds about 1 ms to the resolve", "1, 1", rule::about(),
        "5.01 - 4.02 and 1.10 - .11 ms", {5.01 - 4.02, 1.10 - 0.11});
    add("mm-table1-16x", "4x4 subsampling gives nearly 16x, and a proportional speedup: the stage of Car",
        "16", rule::within(0.1),
        fmt::format(
            "{:.1f} of the whole stage, 2.91 over .25 ms: glass is not subsampled. The sentence is about "
            "Figure 23 alone; Foggy Night's is {:.1f}",
            2.91 / 0.25, 4.32 / 0.37),
        {2.91 / 0.25});
}

}  // namespace

void add_phenomenological_listing_claims(std::vector<Claim>& claims) {
    add_contradictions(claims);
    add_diffusion(claims);
    add_precision(claims);
    add_table1(claims);
}

}  // namespace ropsim
