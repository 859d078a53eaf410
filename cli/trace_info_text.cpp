// What `ropsim trace info` says of a trace, as text.
#include "cli/trace_info.h"

#include <algorithm>

#include <fmt/format.h>

namespace ropsim {

namespace {

constexpr std::size_t kListedDraws = 16;

std::string depth_text(const DepthComplexity& depth, std::size_t pixels) {
    if (!depth.mean) return "no pixel is covered";
    return fmt::format("mean {:.2f}, max {} fragments a pixel, over {} covered pixels ({:.1f}% of the image)",
                       *depth.mean, depth.max, depth.covered_pixels,
                       100.0 * static_cast<double>(depth.covered_pixels) / static_cast<double>(pixels));
}

class InfoText {
 public:
    InfoText(const TraceReader& reader, const TraceStatistics& statistics)
        : reader_(reader),
          header_(reader.header()),
          statistics_(statistics),
          pixels_(static_cast<std::size_t>(header_.width) * static_cast<std::size_t>(header_.height)) {}

    std::string run() {
        text_ = reader_.path() + "\n";
        line("scene", header_.scene.empty() ? "(unnamed)" : header_.scene);
        line("size", fmt::format("{}x{} pixels, {} sample{} a pixel", header_.width, header_.height,
                                 header_.samples, header_.samples == 1 ? "" : "s"));
        line("fragments", fmt::format("{} in {} draw{}", reader_.fragment_count(), header_.draws.size(),
                                      header_.draws.size() == 1 ? "" : "s"));
        draws();
        line("depth complexity", depth_text(statistics_.all, pixels_));
        depth_histogram();
        line("visible", depth_text(statistics_.visible, pixels_));
        line("opaque layer",
             header_.opaque ? fmt::format("hides {}", share(statistics_.hidden_by_opaque)) : "none");
        line("facing back", share(statistics_.facing_back));
        alpha();
        channels();
        view();
        file();
        return std::move(text_);
    }

 private:
    void line(const char* name, const std::string& value) {
        text_ += fmt::format("  {:<18}{}\n", name, value);
    }

    double percent(std::uint64_t count) const {
        if (statistics_.fragments == 0) return 0;
        return 100.0 * static_cast<double>(count) / static_cast<double>(statistics_.fragments);
    }
    std::string share(std::uint64_t count) const {
        return fmt::format("{} fragments ({:.1f}%)", count, percent(count));
    }
    std::string bar(double percent_of_all) const {
        return std::string(static_cast<std::size_t>(percent_of_all / 2.5 + 0.5), '#');
    }

    void draws() {
        for (std::size_t i = 0; i < std::min(header_.draws.size(), kListedDraws); ++i)
            text_ += fmt::format("    {:>5}  {:>11}  {:5.1f}%  {}\n", i, statistics_.draw_fragments[i],
                                 percent(statistics_.draw_fragments[i]), header_.draws[i].name);
        if (header_.draws.size() > kListedDraws)
            text_ += fmt::format("    and {} more draws (--json lists them)\n",
                                 header_.draws.size() - kListedDraws);
    }

    // Pixels by fragments a pixel, in ranges that double: short for any trace.
    void depth_histogram() {
        const std::vector<std::uint64_t>& histogram = statistics_.all.histogram;
        for (std::size_t first = 0; first < histogram.size();) {
            const std::size_t last = first == 0 ? 0 : 2 * first - 1;
            std::uint64_t count = 0;
            for (std::size_t k = first; k <= last && k < histogram.size(); ++k) count += histogram[k];
            const std::string range =
                first == last ? fmt::format("{}", first) : fmt::format("{}-{}", first, last);
            const double of_all = 100.0 * static_cast<double>(count) / static_cast<double>(pixels_);
            text_ +=
                fmt::format("    {:>11}  {:>10} pixels  {:5.1f}%  {}\n", range, count, of_all, bar(of_all));
            first = last + 1;
        }
    }

    void alpha() {
        if (!statistics_.alpha_mean) return;
        line("alpha",
             fmt::format("mean {:.3f}; exactly 0: {:.1f}%, exactly 1: {:.1f}%", *statistics_.alpha_mean,
                         percent(statistics_.zero_alpha), percent(statistics_.full_alpha)));
        for (std::size_t k = 0; k < statistics_.alpha_histogram.size(); ++k) {
            const std::uint64_t count = statistics_.alpha_histogram[k];
            text_ += fmt::format("    {:.1f} to {:.1f}  {:>11}         {:5.1f}%  {}\n",
                                 static_cast<double>(k) / 10, static_cast<double>(k + 1) / 10, count,
                                 percent(count), bar(percent(count)));
        }
    }

    void channels() {
        if (const auto& s = statistics_.slopes)
            line("depth slopes", fmt::format("{} slope, at most {} a pixel", share(s->sloped), s->steepest));
        if (const auto& m = statistics_.materials)
            line("materials", fmt::format("{} transmit, {} scatter, {} refract", share(m->transmissive),
                                          share(m->scattering), share(m->refractive)));
        if (const auto& u = statistics_.unusual)
            line("not finite",
                 fmt::format("{} with NaN, {} with infinity, {} out of range", share(u->with_nan),
                             share(u->with_infinity), share(u->out_of_range)));
    }

    void camera(const char* name, const std::optional<Camera>& camera) {
        if (camera)
            line(name, fmt::format("near {}, far {} scene units, {} degrees high", camera->near_plane,
                                   camera->far_plane, camera->fovy_degrees));
    }
    void view() {
        line("seen from", header_.view);
        camera("camera", header_.camera);
        camera("light", header_.light);
    }

    void file() {
        const std::uint64_t fragments = reader_.fragment_count();
        std::string a_fragment;
        if (fragments != 0)
            a_fragment = fmt::format(", {:.2f} a fragment", static_cast<double>(reader_.file_bytes()) /
                                                                static_cast<double>(fragments));
        line("file", fmt::format("{} bytes{}, colour as {}", reader_.file_bytes(), a_fragment,
                                 header_.color_storage == ColorStorage::kFloat16 ? "float16" : "float32"));
        line("hash", reader_.hash());
    }

    const TraceReader& reader_;
    const TraceHeader& header_;
    const TraceStatistics& statistics_;
    const std::size_t pixels_;
    std::string text_;
};

}  // namespace

std::string trace_info_text(const TraceReader& reader, const TraceStatistics& statistics) {
    return InfoText(reader, statistics).run();
}

}  // namespace ropsim
