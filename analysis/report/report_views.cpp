// Reads the runs' images and turns them into pictures of the page.
#include "analysis/report/report_views.h"

#include "analysis/child_process.h"
#include "analysis/html.h"
#include "analysis/report/picture_encoding.h"
#include "analysis/report/report_inspector.h"
#include "analysis/report/report_pictures.h"
#include "analysis/report/report_tables.h"
#include "base/error.h"
#include "base/parallel.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kCardWidth = 320;  // pixels of a card's picture of the whole frame

struct Loaded {
    const RunRecord* run;
    Image image;  // R, G, B
};

Image colors_of(const Image& image, const std::string& file) {
    const int from[] = {image.channel("R"), image.channel("G"), image.channel("B")};
    if (*std::min_element(from, from + 3) < 0) throw UserError(file, "has no channels R, G, B");
    Image out(image.width, image.height, {"R", "G", "B"});
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            for (int c = 0; c < 3; ++c) out.pixel(x, y)[c] = image.pixel(x, y)[from[c]];
    return out;
}

std::vector<Loaded> load(const ComparisonOfOneTrace& comparison, std::string& unreadable) {
    std::vector<Loaded> loaded;
    for (const RunRecord& run : comparison.runs) {
        if (!run.failure.empty()) continue;
        const std::string file = (std::filesystem::path(run.directory) / "image.exr").string();
        try {
            Image image = colors_of(read_exr(file), file);
            if (image.width != comparison.reference.width || image.height != comparison.reference.height)
                throw UserError(file, "is not an image of this trace");
            loaded.push_back({&run, std::move(image)});
        } catch (const UserError& error) {
            unreadable += fmt::format("<p class=\"note\">{}: {}</p>\n", html_escape(error.where()),
                                      html_escape(error.what()));
        }
    }
    return loaded;
}

// Channels of the image summed, as whole numbers of a picture.
Picture number_picture(const Image& image, const std::vector<std::string>& channels) {
    std::vector<double> values;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            double sum = 0;
            for (const std::string& name : channels)
                if (const int c = image.channel(name); c >= 0)
                    sum += static_cast<double>(image.pixel(x, y)[c]);
            values.push_back(sum);
        }
    return packed_numbers(image.width, image.height, values);
}

// Bytes of each tile; empty where the run's fidelity measures none.
std::string tile_uri(const RunRecord& run) {
    const std::string file = (std::filesystem::path(run.directory) / "tiles.exr").string();
    if (!std::filesystem::exists(file)) return {};
    return picture_uri(number_picture(read_exr(file), {"read", "write"}), PictureLoss::kNone);
}

bool configured(const RunRecord& run, const std::string& key, const std::string& value) {
    const auto found = run.configuration.find(key);
    return found != run.configuration.end() && found->second == value;
}

std::string only_in_frame(const RunRecord& run) {
    if (configured(run, "order", "machine")) return "its fragments arrived in the machine's order";
    if (configured(run, "hardware_parameters.skip.saturated", "true"))
        return "it left out fragments behind saturated pixels (skip.saturated)";
    if (run.pool_nodes_overflowed.value_or(0) > 0) return "the frame's nodes did not fit into its pool";
    return "";
}

std::uint64_t seed_of(const RunRecord& run) {
    std::uint64_t seed = 0;
    if (const auto found = run.configuration.find("seed"); found != run.configuration.end()) {
        const std::string& text = found->second;
        std::from_chars(text.data(), text.data() + text.size(), seed);
    }
    return seed;
}

// Builds the widget of one comparison piece by piece.
class Views {
 public:
    Views(const ComparisonOfOneTrace& comparison, std::string id)
        : comparison_(comparison), id_(std::move(id)), loaded_(load(comparison, unreadable_)) {
        std::vector<const Image*> all;
        all.reserve(loaded_.size());
        for (const Loaded& one : loaded_) all.push_back(&one.image);
        whole_ = {0, 0, comparison.reference.width, comparison.reference.height};
        detail_ = detail_region(all, comparison.reference);
    }

    bool empty() const { return loaded_.empty(); }
    const std::string& unreadable() const { return unreadable_; }

    void add_pictures(std::size_t bytes) {
        std::vector<Picture> pictures{image_picture(comparison_.reference, whole_, 1)};
        for (const Loaded& one : loaded_) {
            pictures.push_back(image_picture(one.image, whole_, 1));
            pictures.push_back(difference_picture(one.image, comparison_.reference, whole_, 1));
        }
        const auto encoded = encode_within(pictures, bytes, default_threads());
        for (const EncodedPicture& picture : encoded) loss_ = std::max(loss_, picture.loss);
        json_["width"] = whole_.width;
        json_["height"] = whole_.height;
        json_["detail"] = Json::array({detail_.x, detail_.y, detail_.width, detail_.height});
        json_["names"] = {{"ours", "technique"},
                          {"theirs", "reference"},
                          {"difference", "difference × 8"},
                          {"note", "grey: none · brighter: too bright · darker: too dark"}};
        json_["curve"] = shell_line({"ropsim", "curve", comparison_.trace});
        json_["reference"] = add("reference", encoded[0].uri);
        json_["layers"] =
            comparison_.reference.channel("layers") < 0
                ? Json(nullptr)
                : Json(add("layers", picture_uri(number_picture(comparison_.reference, {"layers"}),
                                                 PictureLoss::kNone)));
        json_["techniques"] = Json::array();
        for (std::size_t i = 0; i < loaded_.size(); ++i) {
            const std::string tiles = tile_uri(*loaded_[i].run);
            Json technique{{"name", loaded_[i].run->technique},
                           {"image", add(fmt::format("image-{}", i), encoded[1 + 2 * i].uri)},
                           {"difference", add(fmt::format("difference-{}", i), encoded[2 + 2 * i].uri)}};
            technique["tiles"] = tiles.empty() ? Json(nullptr) : Json(add(fmt::format("tiles-{}", i), tiles));
            technique["rmse"] = loaded_[i].run->rmse8 ? Json(*loaded_[i].run->rmse8) : Json(nullptr);
            json_["techniques"].push_back(std::move(technique));
        }
    }

    void add_inspector(const std::vector<PixelPlace>& inspect, std::size_t bytes) {
        std::vector<InspectedRun> runs;
        runs.reserve(loaded_.size());
        for (const Loaded& one : loaded_)
            runs.push_back({one.run->technique, seed_of(*one.run), &one.image, only_in_frame(*one.run)});
        const auto pixels = chosen_pixels(comparison_.reference, runs, inspect);
        const std::set<PixelPlace> asked(inspect.begin(), inspect.end());
        try {
            auto data = inspector_data(id_ + "-pixels", comparison_.trace, comparison_.reference, runs,
                                       pixels, asked.size(), bytes, default_threads());
            for (ReportData& one : data) data_.push_back(std::move(one));
            json_["pixels"] = id_ + "-pixels";
        } catch (const UserError& error) {
            json_["pixels"] = nullptr;
            unreadable_ +=
                fmt::format("<p class=\"note\">The pixel inspector has nothing to show: {}: {}</p>\n",
                            html_escape(error.where()), html_escape(error.what()));
        }
    }

    ReportWidget finish() {
        std::string html = fmt::format(
            "<h3>Pictures</h3>\n<p class=\"note\">Differences are of linear values, 8 times, around grey: "
            "brighter is too bright. Pictures are {}.</p>\n"
            "<div class=\"views\" data-widget=\"views\" data-source=\"{}-views\"></div>\n{}{}",
            loss_text(loss_), id_, unreadable_, cards());
        data_.push_back({id_ + "-views", json_.dump(-1, ' ', false, Json::error_handler_t::replace)});
        return {std::move(html), std::move(data_)};
    }

 private:
    std::string add(const std::string& name, std::string uri) {
        data_.push_back({id_ + "-" + name, std::move(uri), "text/plain"});
        return data_.back().id;
    }

    static std::string picture(const Picture& picture, PictureLoss loss, const std::string& text,
                               const char* style) {
        return fmt::format("<img class=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\" src=\"{}\">", style,
                           picture.width, picture.height, html_escape(text), picture_uri(picture, loss));
    }

    std::string card(const std::string& name, const Image& image, const std::string& numbers, int technique) {
        const Image& reference = comparison_.reference;
        const int reduction = std::max(1, (whole_.width + kCardWidth - 1) / kCardWidth);
        std::string pictures;
        const bool is_reference = technique < 0;
        if (detail_.width > 0)
            pictures +=
                picture(image_picture(image, detail_, 1), PictureLoss::kFine, name + ", a detail", "pixels");
        pictures += is_reference
                        ? picture(image_picture(image, whole_, reduction), PictureLoss::kFine, name, "")
                        : picture(difference_picture(image, reference, whole_, reduction), PictureLoss::kFine,
                                  name + ", difference times 8", "");
        return fmt::format(
            "<figure class=\"card\" data-technique=\"{}\"><div class=\"pair\">{}</div><figcaption><b>{}</b> "
            "{}</figcaption></figure>\n",
            technique, pictures, html_escape(name), numbers);
    }

    std::string cards() {
        std::string out = "<h3>All techniques at a glance</h3>\n<p class=\"note\">";
        if (detail_.width > 0)
            out += fmt::format(
                "Left the {} × {} pixels from ({}, {}) where the techniques err most, right the difference "
                "of the whole frame (of the reference the frame).",
                detail_.width, detail_.height, detail_.x, detail_.y);
        else
            out += "The difference of the whole frame (of the reference the frame).";
        out += "</p>\n<div class=\"cards\">\n" +
               card("reference", comparison_.reference, "exact compositing", -1);
        for (std::size_t i = 0; i < loaded_.size(); ++i) {
            const RunRecord& run = *loaded_[i].run;
            out += card(
                run.technique, loaded_[i].image,
                fmt::format("RMSE {} · FLIP {}", report_number(run.rmse8, 3), report_number(run.flip, 4)),
                static_cast<int>(i));
        }
        return out + "</div>\n";
    }

    const ComparisonOfOneTrace& comparison_;
    std::string id_;
    std::string unreadable_;
    std::vector<Loaded> loaded_;
    Region whole_, detail_;
    PictureLoss loss_ = PictureLoss::kNone;
    Json json_;
    std::vector<ReportData> data_;
};

}  // namespace

ReportWidget report_views(const ComparisonOfOneTrace& comparison, const std::string& id,
                          const std::vector<PixelPlace>& inspect, const ReportBudget& budget) {
    for (const PixelPlace& place : inspect)
        CHECK(place.x >= 0 && place.y >= 0 && place.x < comparison.width && place.y < comparison.height,
              "{},{}", place.x, place.y);
    Views views(comparison, id);
    if (views.empty()) return {views.unreadable(), {}};
    views.add_pictures(budget.picture_bytes);
    views.add_inspector(inspect, budget.inspector_bytes);
    return views.finish();
}

}  // namespace ropsim
