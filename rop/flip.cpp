// LDR-FLIP after Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild: "FLIP: A Difference
// Evaluator for Alternating Images", HPG 2020. Written from the formulas; section numbers are that paper's.
// No deviations: the filters are applied as separable ones, which for these sums of Gaussians is exact.
#include "rop/flip.h"

#include "rop/transcendental.h"

#include <cmath>
#include <numbers>

namespace ropsim {
namespace {

constexpr double kPixelsPerDegree = 67.0;  // 0.7 m from a 0.7 m wide 4K monitor
constexpr double kColorExponent = 0.7;     // q_c
constexpr double kColorKnee = 0.4;         // p_c
constexpr double kColorKneeValue = 0.95;   // p_t
constexpr double kFeatureExponent = 0.5;   // q_f
constexpr double kFeatureWidth = 0.082;    // w, degrees

struct Triple {
    double x, y, z;
};

// Linear sRGB to XYZ for the primaries of IEC 61966-2-1 and a D65 white of (0.3127, 0.3290), rows scaled so
// that white becomes (1, 1, 1): the normalised coordinates are all the metric needs.
constexpr double kToXyz[3][3] = {
    {10135552.0, 8788810.0, 4435075.0}, {2613072.0, 8788810.0, 887015.0}, {1425312.0, 8788810.0, 70074185.0}};

Triple to_xyz(double r, double g, double b) {
    const auto row = [&](const double(&m)[3]) {
        return (m[0] * r + m[1] * g + m[2] * b) / (m[0] + m[1] + m[2]);
    };
    return {row(kToXyz[0]), row(kToXyz[1]), row(kToXyz[2])};
}

// The inverse of to_xyz, by cofactors.
struct FromXyz {
    double m[3][3]{};
    FromXyz() {
        double n[3][3];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) n[i][j] = kToXyz[i][j] / (kToXyz[i][0] + kToXyz[i][1] + kToXyz[i][2]);
        double determinant = 0;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                const int r0 = (j + 1) % 3, r1 = (j + 2) % 3, c0 = (i + 1) % 3, c1 = (i + 2) % 3;
                m[i][j] = n[r0][c0] * n[r1][c1] - n[r0][c1] * n[r1][c0];
            }
            determinant += n[0][i] * m[i][0];
        }
        for (auto& row : m)
            for (double& value : row) value /= determinant;
    }
    Triple operator()(const Triple& c) const {
        return {m[0][0] * c.x + m[0][1] * c.y + m[0][2] * c.z, m[1][0] * c.x + m[1][1] * c.y + m[1][2] * c.z,
                m[2][0] * c.x + m[2][1] * c.y + m[2][2] * c.z};
    }
};

double lab_curve(double t) {
    constexpr double kDelta = 6.0 / 29.0;
    return t > kDelta * kDelta * kDelta ? deterministic_power(t, 1.0 / 3.0)
                                        : t / (3.0 * kDelta * kDelta) + 4.0 / 29.0;
}

// CIELAB with the chroma scaled by lightness, for the Hunt effect (section 4.1.3).
Triple hunt_lab(const Triple& xyz) {
    const double fx = lab_curve(xyz.x), fy = lab_curve(xyz.y), fz = lab_curve(xyz.z);
    const double lightness = 116.0 * fy - 16.0;
    return {lightness, 0.01 * lightness * 500.0 * (fx - fy), 0.01 * lightness * 200.0 * (fy - fz)};
}

// Distance that suits large colour differences: city block between lightness and chroma.
double hyab(const Triple& p, const Triple& q) {
    const double da = p.y - q.y, db = p.z - q.z;
    return std::abs(p.x - q.x) + std::sqrt(da * da + db * db);
}

// Weights exp(-pi^2 d^2 / b) at whole pixels, d in degrees: the inverse Fourier transform of a contrast
// sensitivity exp(-b f^2), without its factor (section 4.1.1). The radius is that of the widest filter, three
// deviations.
std::vector<float> sensitivity_taps(double b) {
    constexpr double kWidest = 0.04;
    constexpr double kPi = std::numbers::pi;
    const int radius =
        static_cast<int>(std::ceil(3.0 * std::sqrt(kWidest / (2.0 * kPi * kPi)) * kPixelsPerDegree));
    std::vector<float> taps;
    for (int i = -radius; i <= radius; ++i) {
        const double degrees = i / kPixelsPerDegree;
        taps.push_back(
            static_cast<float>(deterministic_power(std::numbers::e, -kPi * kPi * degrees * degrees / b)));
    }
    return taps;
}

double sum_of(const std::vector<float>& taps) {
    double sum = 0;
    for (const float tap : taps) sum += tap;
    return sum;
}

std::vector<float> scaled(std::vector<float> taps, double factor) {
    for (float& tap : taps) tap = static_cast<float>(tap * factor);
    return taps;
}

Plane<float> smooth(const Plane<float>& in, double b) {
    auto taps = sensitivity_taps(b);
    taps = scaled(taps, 1.0 / sum_of(taps));
    return filter_down(filter_across(in, taps), taps);
}

// The blue-yellow filter is a sum of two Gaussians, so a weighted sum of two separable filters.
Plane<float> smooth_blue_yellow(const Plane<float>& in) {
    constexpr double kA1 = 34.1, kB1 = 0.04, kA2 = 13.5, kB2 = 0.025;
    const double s1 = sum_of(sensitivity_taps(kB1)), s2 = sum_of(sensitivity_taps(kB2));
    const double w1 = kA1 * std::sqrt(std::numbers::pi / kB1) * s1 * s1;
    const double w2 = kA2 * std::sqrt(std::numbers::pi / kB2) * s2 * s2;
    Plane<float> wide = smooth(in, kB1);
    const Plane<float> narrow = smooth(in, kB2);
    const auto share = static_cast<float>(w1 / (w1 + w2));
    for (std::size_t i = 0; i < wide.values.size(); ++i)
        wide.values[i] = share * wide.values[i] + (1.0f - share) * narrow.values[i];
    return wide;
}

// The opponent space of the filters, up to its constant factors and offsets (which unit-sum filters leave
// alone): luminance, X - Y and Y - Z, all relative to white.
ColorPlanes opponent(const ColorPlanes& rgb) {
    ColorPlanes out;
    for (auto& plane : out) plane = Plane<float>(rgb[0].width, rgb[0].height);
    for_each_row(rgb[0].height, [&](int y) {
        for (int x = 0; x < rgb[0].width; ++x) {
            const Triple c = to_xyz(rgb[0].row(y)[x], rgb[1].row(y)[x], rgb[2].row(y)[x]);
            out[0].row(y)[x] = static_cast<float>(c.y);
            out[1].row(y)[x] = static_cast<float>(c.x - c.y);
            out[2].row(y)[x] = static_cast<float>(c.y - c.z);
        }
    });
    return out;
}

// What the eye resolves: filtered by contrast sensitivity, clamped to what the monitor can show
// (section 4.1.2).
ColorPlanes perceived(const ColorPlanes& in) {
    return {smooth(in[0], 0.0047), smooth(in[1], 0.0053), smooth_blue_yellow(in[2])};
}

Triple perceived_lab(const ColorPlanes& planes, int x, int y, const FromXyz& from_xyz) {
    const double luminance = planes[0].row(y)[x];
    const Triple rgb =
        from_xyz({luminance + planes[1].row(y)[x], luminance, luminance - planes[2].row(y)[x]});
    const auto unit = [](double v) { return std::clamp(v, 0.0, 1.0); };
    return hunt_lab(to_xyz(unit(rgb.x), unit(rgb.y), unit(rgb.z)));
}

// Lengths of the edge and the point response of a luminance plane (section 4.2).
struct Features {
    Plane<float> edge_x, edge_y, point_x, point_y;
    double edge(int x, int y) const { return length(edge_x.row(y)[x], edge_y.row(y)[x]); }
    double point(int x, int y) const { return length(point_x.row(y)[x], point_y.row(y)[x]); }
    static double length(double u, double v) { return std::sqrt(u * u + v * v); }
};

Features features(const Plane<float>& luminance) {
    const double deviation = 0.5 * kFeatureWidth * kPixelsPerDegree;
    const int radius = static_cast<int>(std::ceil(3.0 * deviation));
    std::vector<float> smoothing, slope, curvature;
    double slope_sum = 0, rise = 0, fall = 0;
    for (int i = -radius; i <= radius; ++i) {
        const double u = i / deviation;
        const double g = deterministic_power(std::numbers::e, -0.5 * u * u);
        smoothing.push_back(static_cast<float>(g));
        slope.push_back(static_cast<float>(i * g));
        curvature.push_back(static_cast<float>((u * u - 1.0) * g));
        slope_sum += std::max(0.0, i * g);
        (curvature.back() > 0 ? rise : fall) += std::abs(static_cast<double>(curvature.back()));
    }
    // Positive and negative weights each add up to one in size.
    smoothing = scaled(smoothing, 1.0 / sum_of(smoothing));
    slope = scaled(slope, 1.0 / slope_sum);
    for (float& tap : curvature) tap = static_cast<float>(tap / (tap > 0 ? rise : fall));
    const Plane<float> smooth_across = filter_across(luminance, smoothing);
    return {filter_down(filter_across(luminance, slope), smoothing), filter_down(smooth_across, slope),
            filter_down(filter_across(luminance, curvature), smoothing),
            filter_down(smooth_across, curvature)};
}

// Maps the colour distance to [0, 1]: most of the range for the differences that occur (section 4.1.4).
double redistribute(double distance, double largest) {
    const double error = deterministic_power(distance, kColorExponent);
    const double knee = kColorKnee * largest;
    if (error < knee) return kColorKneeValue / knee * error;
    return kColorKneeValue + (error - knee) / (largest - knee) * (1.0 - kColorKneeValue);
}

}  // namespace

double mean_flip(const ColorPlanes& image, const ColorPlanes& reference) {
    const FromXyz from_xyz;
    const double largest =
        deterministic_power(hyab(hunt_lab(to_xyz(0, 1, 0)), hunt_lab(to_xyz(0, 0, 1))), kColorExponent);
    const ColorPlanes image_opponent = opponent(image);
    const ColorPlanes reference_opponent = opponent(reference);
    const Features f = features(image_opponent[0]);
    const Features g = features(reference_opponent[0]);
    const ColorPlanes p = perceived(image_opponent);
    const ColorPlanes q = perceived(reference_opponent);
    return mean_of_pixels(0, 0, image[0].width, image[0].height, [&](int x, int y) {
        const double distance = hyab(perceived_lab(p, x, y, from_xyz), perceived_lab(q, x, y, from_xyz));
        const double color = std::min(1.0, redistribute(distance, largest));
        if (color == 0.0) return 0.0;
        const double feature =
            std::max(std::abs(f.edge(x, y) - g.edge(x, y)), std::abs(f.point(x, y) - g.point(x, y)));
        const double structure =
            std::min(1.0, deterministic_power(feature / std::numbers::sqrt2, kFeatureExponent));
        return deterministic_power(color, 1.0 - structure);
    });
}

}  // namespace ropsim
