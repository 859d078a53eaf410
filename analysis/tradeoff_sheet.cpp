// The layout of the picture of error against bytes.
#include "analysis/tradeoff_sheet.h"

#include "analysis/standard_techniques.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

// Of the SVG, in pixels.
constexpr double kPanelWidth = 760;
constexpr double kPanelHeight = 560;
constexpr double kKeyColumn = 300;  // one entry
constexpr double kKeyRow = 24;

std::size_t key_columns(const TradeoffSheet& sheet) {
    return static_cast<std::size_t>(sheet.width / kKeyColumn);
}

std::vector<TradeoffMark> marks_of(const Tradeoff& tradeoff, std::size_t scene) {
    std::vector<TradeoffMark> marks;
    const TradeoffBytesKind& kind = bytes_kind(tradeoff.options.bytes);
    const std::vector<bool> front_beside =
        kind.beside ? scene_front(tradeoff, scene, *kind.beside) : std::vector<bool>{};
    for (std::size_t t = 0; t < tradeoff.techniques.size(); ++t) {
        const TradeoffTechnique& technique = tradeoff.techniques[t];
        const TradeoffPoint& point = technique.at[scene];
        const Measured& bytes = point.*kind.member;
        if (!point.rmse8 || !bytes || *bytes <= 0) continue;
        TradeoffMark mark{*bytes, *point.rmse8,     point.front,         point.fixed_front,
                          0,      technique.family, &technique.technique};
        if (kind.beside) {
            mark.beside = (point.*bytes_kind(*kind.beside).member).value_or(0);
            mark.fixed_front = front_beside[t];
        }
        marks.push_back(mark);
    }
    std::stable_sort(marks.begin(), marks.end(), [](const TradeoffMark& a, const TradeoffMark& b) {
        return a.bytes != b.bytes ? a.bytes < b.bytes : a.error > b.error;
    });
    return marks;
}

void set_ranges(TradeoffPanel& panel) {
    double low = HUGE_VAL, high = 0, error_low = HUGE_VAL, error_high = 0;
    for (const TradeoffMark& mark : panel.marks) {
        low = std::min({low, mark.bytes, mark.second()});
        high = std::max({high, mark.bytes, mark.second()});
        error_high = std::max(error_high, mark.error);
        if (mark.error > 0)
            error_low = std::min(error_low, mark.error);
        else
            panel.zero = true;
    }
    if (error_high == 0) error_low = error_high = 1;  // only zeros: any axis will do
    // Room for marks and names at the ends.
    const double wide = std::pow(std::max(high / low, 4.0), 0.06);
    panel.bytes_low = low / wide;
    panel.bytes_high = high * wide;
    const double tall = std::pow(std::max(error_high / error_low, 4.0), 0.07);
    panel.error_low = error_low / (panel.zero ? std::pow(tall, 2.5) : tall);
    panel.error_high = error_high * tall;
}

}  // namespace

PicturePoint TradeoffPanel::place(const TradeoffMark& mark) const {
    const auto share = [](double value, double low, double high) {
        return std::log(value / low) / std::log(high / low);
    };
    return {
        box.left + (box.right - box.left) * share(mark.bytes, bytes_low, bytes_high),
        box.bottom + (box.top - box.bottom) * share(std::max(mark.error, error_low), error_low, error_high)};
}

TradeoffSheet tradeoff_sheet(const Tradeoff& tradeoff) {
    TradeoffSheet sheet;
    sheet.bytes = bytes_kind(tradeoff.options.bytes).axis;
    if (bytes_kind(tradeoff.options.bytes).beside) sheet.fronts = kTradeoffFrontsBeside;
    for (std::size_t s = 0; s < tradeoff.scenes.size(); ++s) {
        TradeoffPanel panel;
        panel.scene = &tradeoff.scenes[s];
        panel.marks = marks_of(tradeoff, s);
        if (panel.marks.empty()) continue;
        set_ranges(panel);
        sheet.panels.push_back(std::move(panel));
    }
    const std::size_t columns = sheet.panels.size() == 1 ? 1 : 2;
    const std::size_t rows = (sheet.panels.size() + columns - 1) / columns;
    sheet.width = kPanelWidth * static_cast<double>(columns);
    for (std::size_t f = 0; f < technique_families().size(); ++f) {
        const auto shows = [f](const TradeoffPanel& panel) {
            return std::any_of(panel.marks.begin(), panel.marks.end(),
                               [f](const TradeoffMark& mark) { return mark.family == f; });
        };
        if (std::any_of(sheet.panels.begin(), sheet.panels.end(), shows)) sheet.families.push_back(f);
    }
    // The lines of the fronts are entries too.
    const std::size_t key_rows =
        (sheet.fronts.size() + sheet.families.size() + key_columns(sheet) - 1) / key_columns(sheet);
    sheet.key_height = kKeyRow * static_cast<double>(key_rows) + 16;
    sheet.height = kPanelHeight * static_cast<double>(rows) + sheet.key_height;
    for (std::size_t p = 0; p < sheet.panels.size(); ++p) {
        const std::size_t row = p / columns;
        const double left = kPanelWidth * static_cast<double>(p % columns);
        const double top = sheet.height - kPanelHeight * static_cast<double>(row);
        sheet.panels[p].box = {left + 80, top - kPanelHeight + 62, left + kPanelWidth - 20, top - 40};
    }
    return sheet;
}

std::vector<PicturePoint> key_places(const TradeoffSheet& sheet) {
    std::vector<PicturePoint> places;
    const std::size_t columns = key_columns(sheet);
    const double indent = (sheet.width - kKeyColumn * static_cast<double>(columns)) / 2 + 40;
    for (std::size_t i = 0; i < sheet.fronts.size() + sheet.families.size(); ++i) {
        const std::size_t row = i / columns;
        places.push_back({indent + kKeyColumn * static_cast<double>(i % columns),
                          sheet.key_height - 16 - kKeyRow * static_cast<double>(row)});
    }
    return places;
}

}  // namespace ropsim
