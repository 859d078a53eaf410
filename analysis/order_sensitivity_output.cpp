// Order sensitivity for programs and for readers.
#include "analysis/comparison_table.h"
#include "analysis/convergence_fit.h"
#include "analysis/order_sensitivity.h"
#include "analysis/text_table.h"
#include "base/version.h"

#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr struct {
    const char* key;
    double SpreadFigures::*member;
    const char* unit;
} kSpread[] = {
    {"rms_sd8", &SpreadFigures::rms_sd8,
     "1/255 of linear full scale: root of the mean, over covered pixels and channels, of a value's variance "
     "over the random orders (n - 1)"},
    {"mean_spread8", &SpreadFigures::mean_spread8,
     "1/255 of linear full scale: mean of a value's largest minus smallest over the random orders"},
    {"max_spread8", &SpreadFigures::max_spread8, "1/255 of linear full scale: the largest of them"},
    {"differing_share", &SpreadFigures::differing,
     "share of the covered pixels that are not the same in all random orders"},
};

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json technique_json(const OrderSensitivityOfTechnique& t) {
    Json json = {{"technique", t.technique},
                 {"technique_parameters", t.parameters},
                 {"any_order", t.any_order},
                 {"random", t.random},
                 {"why_null", t.failure.empty() ? Json(nullptr) : Json(t.failure)}};
    const bool ran = t.failure.empty();
    for (const auto& s : kSpread) json[s.key] = ran ? number(t.spread.*s.member) : Json(nullptr);
    Json errors;
    for (std::size_t i = 0; i < kNamedOrders.size(); ++i)
        errors[kNamedOrders[i]] = ran ? number(t.named_rmse8_covered[i]) : Json(nullptr);
    errors["random"] = Json::array();
    for (const double error : t.random_rmse8_covered) errors["random"].push_back(number(error));
    json["rmse8_covered"] = errors;
    return json;
}

Json units_json() {
    Json units;
    for (const auto& s : kSpread) units[s.key] = s.unit;
    units["any_order"] =
        "whether the technique declares that any order gives the same image, up to ties and rounding";
    units["random"] = "whether the image depends on the seed, which is the same in all orders";
    units["rmse8_covered"] =
        "1/255 of linear full scale, against the reference, pixels with a transparent fragment, by order";
    return units;
}

using Row = std::vector<std::string>;

std::string shown(double value, int decimals) {
    return format_measured(value, decimals, ",", "-");
}

Row row_of(const OrderSensitivityOfTechnique& t) {
    const SpreadFigures& s = t.spread;
    Row row{t.technique,
            t.any_order ? "any" : "raster",
            shown(s.rms_sd8, 3),
            shown(s.mean_spread8, 3),
            shown(s.max_spread8, 1),
            shown(100 * s.differing, 1)};
    for (const double error : t.named_rmse8_covered) row.push_back(shown(error, 3));
    const MeanSd random = mean_sd(t.random_rmse8_covered);
    row.push_back(shown(random.mean, 3));
    row.push_back(shown(random.sd.value_or(NAN), 3));
    return row;
}

}  // namespace

std::string order_sensitivity_json(const OrderSensitivity& study) {
    const OrderSensitivityOptions& o = study.options;
    Json json;
    json["ropsim"] = kVersion;
    json["trace"] = {{"file", o.trace},
                     {"hash", study.trace_hash},
                     {"scene", study.scene},
                     {"width", study.width},
                     {"height", study.height},
                     {"samples", study.samples},
                     {"fragments", study.fragments}};
    json["covered_pixels"] = study.covered_pixels;
    json["configuration"] = {{"orders", o.orders},  {"order_seed", o.order_seed}, {"seed", o.seed},
                             {"fidelity", "count"}, {"hardware", o.hardware},     {"set", o.settings}};
    json["units"] = units_json();
    json["techniques"] = Json::array();
    for (const OrderSensitivityOfTechnique& t : study.techniques)
        json["techniques"].push_back(technique_json(t));
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string order_sensitivity_csv(const OrderSensitivity& study) {
    std::string text = "technique,any_order,random";
    for (const auto& s : kSpread) text += fmt::format(",{}", s.key);
    for (const char* order : kNamedOrders) text += fmt::format(",rmse8_covered_{}", order);
    for (int i = 0; i < study.options.orders; ++i)
        text +=
            fmt::format(",rmse8_covered_order_{}", study.options.order_seed + static_cast<std::uint64_t>(i));
    text += ",failure\n";
    const auto field = [](double value) { return std::isfinite(value) ? fmt::format(",{}", value) : ","; };
    for (const OrderSensitivityOfTechnique& t : study.techniques) {
        text += csv_field(t.technique);
        if (!t.failure.empty()) {
            text += std::string(2 + std::size(kSpread) + kNamedOrders.size() +
                                    static_cast<std::size_t>(study.options.orders),
                                ',') +
                    "," + csv_field(t.failure) + "\n";
            continue;
        }
        text += fmt::format(",{},{}", t.any_order ? 1 : 0, t.random ? 1 : 0);
        for (const auto& s : kSpread) text += field(t.spread.*s.member);
        for (const double error : t.named_rmse8_covered) text += field(error);
        for (const double error : t.random_rmse8_covered) text += field(error);
        text += ",\n";
    }
    return text;
}

std::string order_sensitivity_table(const OrderSensitivity& study) {
    std::vector<Row> rows{{"technique", "order", "sd", "mean", "max", "differ", "captured", "near first",
                           "far first", "random", "sd"},
                          {"", "", "/255", "/255", "/255", "% px", "RMSE", "RMSE", "RMSE", "RMSE", ""}};
    for (const OrderSensitivityOfTechnique& t : study.techniques) {
        if (t.failure.empty())
            rows.push_back(row_of(t));
        else
            rows.push_back({fmt::format("{}  refused: {}", t.technique, t.failure)});
    }
    return aligned_table(rows) +
           fmt::format(
               "\nsd, mean, max, differ: of a value over {} random orders (root mean square of its standard "
               "deviation, mean and\nlargest of its range, pixels that are not always the same). RMSE "
               "against "
               "the reference. All over the {} pixels with a\ntransparent fragment. order any: declared "
               "independent of it, up to ties and rounding.\n",
               study.options.orders, study.covered_pixels);
}

}  // namespace ropsim
