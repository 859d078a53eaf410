// Equations 11 to 13 of McGuire and Mara 2017, by the formulas in double precision, and what they do where
// the paper says two things.
#include "rop/shadow/caustics.h"

#include <cfloat>
#include <cmath>
#include <limits>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

Material glass(float index, std::array<float, 3> transmission = {0.75f, 0.5f, 0.0f}) {
    Material m;
    m.eta = index;
    for (std::size_t c = 0; c < 3; ++c) m.transmission[c] = transmission[c];
    return m;
}

// As printed, for eta = eta_before / eta_after.
double printed_rho(double eta, double incidence, double alpha, double t) {
    const double s = std::min(std::max((1 / eta - 1) / 2, 0.0), 1.0);
    const double g = 2 * std::min(std::max(1 - std::pow(incidence, 128 * s * s), 0.0), 1.0) - 1;
    return std::min(1.0, (1 + g * std::pow(s, 0.2)) * alpha * (1 - t));
}

TEST(Caustics, AreEquations11To13ForLightThatEntersTheMedium) {
    const CausticModel model;
    for (const double index : {1.0, 1.05, 1.25, 1.3, 1.5, 2.4, 3.0, 4.0})
        for (const double incidence : {0.0, 0.01, 0.3, 0.7071, 0.99, 1.0})
            for (const double alpha : {0.0, 0.2, 1.0}) {
                const Material m = glass(static_cast<float>(index));
                const auto rho = shadow_probability(model, static_cast<float>(alpha), m,
                                                    static_cast<float>(incidence), false);
                for (std::size_t c = 0; c < 3; ++c)
                    EXPECT_NEAR(
                        rho[c],
                        printed_rho(1 / index, incidence, alpha, static_cast<double>(m.transmission[c])),
                        2e-6)
                        << index << ' ' << incidence << ' ' << alpha;
            }
}

// "We decrease shadowing where light strikes a transmissive surface at normal incidence" is what the
// equations do; "we increase rho where the magnitude of the dot product is close to 1", two sentences on, is
// not.
TEST(Caustics, EquationsLightenNormalIncidenceAndProseDarkensIt) {
    const double strength = std::pow(0.25, 0.2);  // of glass: s = (1.5 - 1) / 2
    CausticModel model;
    EXPECT_NEAR(strength, 0.7579, 5e-5);
    EXPECT_NEAR(caustic_factor(model, 1.5f, 1.0f, false), 1 - strength, 1e-6);
    EXPECT_NEAR(caustic_factor(model, 1.5f, 0.0f, false), 1 + strength, 1e-6);
    model.sign = CausticSign::kProse;
    EXPECT_NEAR(caustic_factor(model, 1.5f, 1.0f, false), 1 + strength, 1e-6);
    EXPECT_NEAR(caustic_factor(model, 1.5f, 0.0f, false), 1 - strength, 1e-6);
    // A flat pane in the sun at 45 degrees focuses nothing, yet casts 1.66 times its shadow.
    model.sign = CausticSign::kEquations;
    EXPECT_NEAR(caustic_factor(model, 1.5f, std::sqrt(0.5f), false), 1 + strength * (1 - 2.0 / 16), 1e-6);
}

TEST(Caustics, VanishWithoutRefractionWhateverZeroToTheZeroIs) {
    for (const CausticSign sign : {CausticSign::kEquations, CausticSign::kProse})
        for (const float incidence : {0.0f, 1e-40f, 0.5f, 1.0f}) {
            const CausticModel model{true, sign, CausticIndex::kMaterial};
            EXPECT_EQ(caustic_factor(model, 1.0f, incidence, false), 1.0f);
            EXPECT_EQ(caustic_factor(model, 0.7f, incidence, false), 1.0f) << "s is clamped at 0";
            const auto rho = shadow_probability(model, 0.8f, glass(1.0f), incidence, false);
            EXPECT_EQ(rho[0], 0.8f * 0.25f);
            EXPECT_EQ(rho[2], 0.8f);
        }
    EXPECT_EQ(caustic_factor({false, {}, {}}, 1.5f, 1.0f, false), 1.0f);
}

TEST(Caustics, AreFiniteForAnyMaterial) {
    for (const float index :
         {-FLT_MAX, -1.0f, -0.0f, 0.0f, FLT_MIN, 0.5f, std::nextafter(1.0f, 2.0f), 1.5f, 65504.0f, FLT_MAX})
        for (const float incidence : {0.0f, FLT_TRUE_MIN, FLT_MIN, 1e-20f, 0.5f, 1.0f, 1.0001f})
            for (const bool back : {false, true})
                for (const CausticIndex reading : {CausticIndex::kMaterial, CausticIndex::kInterface}) {
                    const CausticModel model{true, CausticSign::kEquations, reading};
                    for (const float rho : shadow_probability(model, 1.0f, glass(index), incidence, back))
                        EXPECT_TRUE(rho >= 0.0f && rho <= 1.0f) << index << ' ' << incidence << ' ' << rho;
                    const float mean = mean_shadow_probability(model, 1.0f, glass(index), incidence, back);
                    EXPECT_TRUE(mean >= 0.0f && mean <= 1.0f) << index << ' ' << incidence;
                }
}

// A sphere seen from the light: the mean of |n . w|^k over its disc is 2 / (k + 2). The equations call it
// redistribution; they keep the light of the shadow only at index 1.25, give below and take above.
TEST(Caustics, KeepASpheresLightOnlyAtIndexOneAndAQuarter) {
    const auto mean_factor = [](float index) {
        constexpr int kRings = 20000;
        double sum = 0;
        for (int i = 0; i < kRings; ++i)  // rings of equal area
            sum += static_cast<double>(
                caustic_factor({}, index, static_cast<float>(std::sqrt(1 - (i + 0.5) / kRings)), false));
        return sum / kRings;
    };
    const auto closed_form = [](double index) {
        const double s = (index - 1) / 2;
        return 1 + std::pow(s, 0.2) * (1 - 4 / (128 * s * s + 2));
    };
    for (const double index : {1.01, 1.1, 1.25, 1.3, 1.5})
        EXPECT_NEAR(mean_factor(static_cast<float>(index)), closed_form(index), 1e-3) << index;
    EXPECT_NEAR(closed_form(1.25), 1.0, 1e-12);
    EXPECT_NEAR(closed_form(1.5), 1.4547, 1e-4);
    EXPECT_NEAR(closed_form(1.3), 1.1234, 1e-4);
    // Close to air the contrast is gone but its strength is not: everything is lit by more than a third.
    EXPECT_NEAR(closed_form(1.01), 0.6545, 1e-4);
}

TEST(Caustics, OfAnInterfaceVanishWhereLightLeaves) {
    const CausticModel model{true, CausticSign::kEquations, CausticIndex::kInterface};
    EXPECT_EQ(caustic_factor(model, 1.5f, 1.0f, true), 1.0f);
    EXPECT_EQ(caustic_factor(model, 1.5f, 1.0f, false), caustic_factor({}, 1.5f, 1.0f, false));
    EXPECT_EQ(caustic_factor({}, 1.5f, 1.0f, true), caustic_factor({}, 1.5f, 1.0f, false));
    // Figure 10's labels, eta = 1.3 and 1.5, put into equation 11 as they stand: no caustic at all.
    for (const float eta : {1.3f, 1.5f}) EXPECT_EQ(caustic_strength(1.0f / eta, false), 0.0f);
    // A bubble in glass: light that leaves it, into the denser medium, is bent.
    EXPECT_FLOAT_EQ(caustic_strength(1.0f / 1.5f, true), 0.25f);
}

TEST(Caustics, OneMapTakesTheMeanTransmission) {
    const Material m = glass(1.0f, {1.0f, 0.5f, 0.0f});
    EXPECT_FLOAT_EQ(mean_shadow_probability({}, 0.6f, m, 1.0f, false), 0.3f);
    EXPECT_FLOAT_EQ(mean_shadow_probability({}, 0.6f, Material{}, 1.0f, false), 0.6f);
}

TEST(LightDirection, IsTheEyeOfAPerspectiveLightAndStraightAheadOtherwise) {
    Camera camera;
    camera.projection = glm::perspective(glm::radians(90.0f), 1.0f, 0.1f, 10.0f);
    const LightDirections spot(camera, 64, 64);
    EXPECT_FALSE(spot.parallel());
    const glm::vec3 ahead = spot.at(32, 32);
    EXPECT_NEAR(ahead.z, 1.0f, 1e-6);
    // The top left corner of the view shows points along (-1, 1, -1).
    const glm::vec3 corner = spot.at(0, 0);
    const float third = 1 / std::sqrt(3.0f);
    EXPECT_NEAR(corner.x, third, 1e-6);
    EXPECT_NEAR(corner.y, -third, 1e-6);
    EXPECT_NEAR(corner.z, third, 1e-6);
    camera.projection = glm::ortho(-2.0f, 2.0f, -1.0f, 1.0f, 1.0f, 5.0f);
    const LightDirections sun(camera, 64, 32);
    EXPECT_TRUE(sun.parallel());
    EXPECT_EQ(sun.at(0, 0), glm::vec3(0, 0, 1));
    EXPECT_EQ(LightDirections(std::nullopt, 4, 4).at(1, 1), glm::vec3(0, 0, 1));
    camera.projection = glm::mat4(0.0f);
    camera.projection[2][3] = -1;
    EXPECT_EQ(LightDirections(camera, 4, 4).at(1, 1), glm::vec3(0, 0, 1)) << "cannot be inverted";
}

TEST(LightDirection, IncidenceIsTheCosineWhicheverWayTheNormalLooks) {
    const LightDirections sun(std::nullopt, 8, 8);
    Fragment f{};
    Material m;
    m.normal[0] = 0.8f;
    m.normal[2] = -0.6f;
    EXPECT_FLOAT_EQ(sun.incidence(f, m), 0.6f);
    m.normal[2] = std::numeric_limits<float>::max();
    EXPECT_EQ(sun.incidence(f, m), 1.0f) << "of a normal that is none";
}

}  // namespace
}  // namespace ropsim
