// A heat map of how many fragments each pixel has.
#include "traces/overdraw_picture.h"

#include "base/error.h"
#include "traces/exact_log2.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

namespace ropsim {

namespace {

constexpr int kSmallestWidth = 256;
constexpr int kMargin = 8;
constexpr int kBarHeight = 12;
constexpr int kTickHeight = 5;
constexpr int kDigitWidth = 3, kDigitHeight = 5, kDigitScale = 2;
constexpr int kDigitAdvance = (kDigitWidth + 1) * kDigitScale;
constexpr int kScaleHeight = kMargin + kBarHeight + kTickHeight + 2 + kDigitHeight * kDigitScale + kMargin;
constexpr glm::vec3 kInk{0.8f};
constexpr glm::vec3 kPaper{0.0f};

// OKLab to linear sRGB (B. Ottosson, "A perceptual color space for image processing", 2020).
glm::vec3 linear_from_oklab(float lightness, float a, float b) {
    const auto cube = [](float v) { return v * v * v; };
    const float l = cube(lightness + 0.3963377774f * a + 0.2158037573f * b);
    const float m = cube(lightness - 0.1055613458f * a - 0.0638541728f * b);
    const float s = cube(lightness - 0.0894841775f * a - 1.2914855480f * b);
    return {4.0767416621f * l - 3.3077115913f * m + 0.2309699292f * s,
            -1.2684380046f * l + 2.6097574011f * m - 0.3413193965f * s,
            -0.0041960863f * l - 0.7034186147f * m + 1.7076147010f * s};
}

// t in [0, 1]: violet, blue, green, yellow; lightness from 0.3 to 0.95 in proportion.
glm::vec3 heat(float t) {
    constexpr std::array<glm::vec2, 4> kHues{
        {{0.08f, -0.14f}, {-0.04f, -0.11f}, {-0.13f, 0.08f}, {-0.04f, 0.18f}}};
    const float place = std::clamp(t, 0.0f, 1.0f) * (kHues.size() - 1);
    const auto before = std::min(static_cast<std::size_t>(place), kHues.size() - 2);
    const glm::vec2 hue = glm::mix(kHues[before], kHues[before + 1], place - static_cast<float>(before));
    return glm::clamp(linear_from_oklab(0.3f + 0.65f * t, hue.x, hue.y), 0.0f, 1.0f);
}

class Painter {
 public:
    Painter(int width, int height) : image(width, height, {"R", "G", "B"}) {}

    void fill(int left, int top, int width, int height, const glm::vec3& color) {
        for (int y = std::max(0, top); y < std::min(image.height, top + height); ++y)
            for (int x = std::max(0, left); x < std::min(image.width, left + width); ++x)
                for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = color[c];
    }
    // Decimal digits and the letters of KiB from a 3x5 raster, a bit a dot, the top row in the highest bits.
    void number(int left, int top, const std::string& digits) {
        constexpr std::string_view kSigns = "0123456789KiB";
        constexpr std::array<unsigned, kSigns.size()> kDots{075557, 026227, 071747, 071717, 055711,
                                                            074717, 074757, 071222, 075757, 075717,
                                                            055655, 020222, 065656};
        for (const char digit : digits) {
            const std::size_t sign = kSigns.find(digit);
            CHECK(sign != std::string_view::npos, "'{}'", digit);
            for (int dot = 0; dot < kDigitWidth * kDigitHeight; ++dot)
                if (kDots[sign] >> (kDigitWidth * kDigitHeight - 1 - dot) & 1u)
                    fill(left + dot % kDigitWidth * kDigitScale, top + dot / kDigitWidth * kDigitScale,
                         kDigitScale, kDigitScale, kInk);
            left += kDigitAdvance;
        }
    }

    Image image;
};

// Place of a count on the scale from 1 to `largest`.
float place_of(std::uint32_t count, std::uint32_t largest) {
    if (largest <= 1) return 1;
    return exact_log2(count) / exact_log2(largest);
}

// The bar, a tick at each power of two, its number where there is room, and the largest number at the end.
void paint_scale(Painter& painter, int top, std::uint32_t largest, const std::string& unit) {
    const int left = kMargin;
    const std::string last = std::to_string(largest);
    const int behind = unit.empty() ? 0 : static_cast<int>(unit.size() + 1) * kDigitAdvance;
    const int width =
        painter.image.width - 2 * kMargin - static_cast<int>(last.size()) * kDigitAdvance / 2 - behind;
    const int bar_top = top + kMargin;
    for (int x = 0; x < width; ++x)
        painter.fill(left + x, bar_top, 1, kBarHeight,
                     heat(static_cast<float>(x) / static_cast<float>(width - 1)));
    const int number_top = bar_top + kBarHeight + kTickHeight + 2;
    const auto tick = [&](std::uint32_t count) {
        const int x =
            left + static_cast<int>(std::lround(place_of(count, largest) * static_cast<float>(width - 1)));
        painter.fill(x, bar_top + kBarHeight, 1, kTickHeight, kInk);
        return x;
    };
    const auto extent = [](const std::string& digits) {
        return static_cast<int>(digits.size()) * kDigitAdvance;
    };
    const int last_left = tick(largest) - extent(last) / 2;
    painter.number(last_left, number_top, last);
    painter.number(painter.image.width - kMargin - behind + kDigitAdvance, number_top, unit);
    int free_from = 0;
    for (std::uint64_t power = 1; power < largest; power *= 2) {
        const std::string digits = std::to_string(power);
        const int x = tick(static_cast<std::uint32_t>(power)) - extent(digits) / 2;
        if (x < free_from || x + extent(digits) > last_left) continue;
        painter.number(std::max(0, x), number_top, digits);
        free_from = x + extent(digits) + kDigitAdvance / 2;
    }
}

}  // namespace

Image overdraw_picture(const std::vector<std::uint32_t>& layers, int width, int height,
                       const std::string& unit) {
    CHECK(layers.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height) &&
              !layers.empty(),
          "{} entries for {}x{}", layers.size(), width, height);
    const int factor = (kSmallestWidth + width - 1) / width;
    const std::uint32_t largest = *std::max_element(layers.begin(), layers.end());
    Painter painter(width * factor, height * factor + (largest != 0 ? kScaleHeight : 0));
    painter.fill(0, 0, painter.image.width, painter.image.height, kPaper);
    // Few different counts, many pixels: each colour is computed once.
    std::vector<glm::vec3> colors(std::size_t{largest} + 1, kPaper);
    for (std::uint32_t count = 1; count <= largest; ++count) colors[count] = heat(place_of(count, largest));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::uint32_t count = layers[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                               static_cast<std::size_t>(x)];
            if (count != 0) painter.fill(x * factor, y * factor, factor, factor, colors[count]);
        }
    if (largest != 0) paint_scale(painter, height * factor, largest, unit);
    return std::move(painter.image);
}

}  // namespace ropsim
