// Reads the deep OpenEXR files of other programs as fragments without an arrival order.
#include "traces/interchange/deep_exr_foreign.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <ImfChannelList.h>

namespace ropsim {

namespace {

constexpr float kAlphaSlack = 0x1p-10f;  // above 1: a half's rounding, in other programs' sums

struct ForeignSample {
    float z, z_back, r, g, b, a;
};

class ForeignReader {
 public:
    explicit ForeignReader(DeepExrFile& file) : file_(file) {}

    ForeignDeepImage run() {
        const std::vector<DeepChannel> channels = choose_channels();
        start_header();
        const std::uint64_t count = file_.samples();
        if (count >= std::uint64_t{1} << 32)
            file_.fail(
                fmt::format("holds {} samples; a deep image of up to 2^32 - 1 can be imported", count));
        image_.fragments.reserve(count);
        image_.start.reserve(
            static_cast<std::size_t>(file_.width()) * static_cast<std::size_t>(file_.height()) + 1);
        image_.start.push_back(0);
        DeepRow<ForeignSample> row(file_.left(), file_.width(), channels);
        file_.attach(row);
        for (int y = 0; y < file_.height(); ++y) {
            file_.read_row(y, row);
            take_row(row, y);
        }
        scale_depths();
        add_notes();
        return std::move(image_);
    }

 private:
    [[noreturn]] void fail_at(std::size_t x, std::size_t y, const std::string& what) const {
        file_.fail(fmt::format("pixel ({}, {}): {}", file_.left() + static_cast<std::int64_t>(x),
                               file_.top() + static_cast<std::int64_t>(y), what));
    }

    std::vector<DeepChannel> choose_channels() {
        const Imf::ChannelList& list = file_.header().channels();
        const auto has = [&](const char* name) { return list.findChannel(name) != nullptr; };
        for (const char* name : {"Z", "A"})
            if (!has(name))
                file_.fail(
                    fmt::format("has no channel '{}'; a deep image needs Z, A and R, G, B (or Y)", name));
        const bool colored = has("R") && has("G") && has("B");
        if (!colored && !has("Y"))
            file_.fail("has no channels R, G, B nor Y; a deep image without colour cannot be composited");
        grey_ = !colored;
        has_back_ = has("ZBack");
        std::vector<DeepChannel> channels{{"Z", Imf::FLOAT, offsetof(ForeignSample, z)},
                                          {"A", Imf::FLOAT, offsetof(ForeignSample, a)}};
        channels.push_back({grey_ ? "Y" : "R", Imf::FLOAT, offsetof(ForeignSample, r)});
        if (!grey_) channels.push_back({"G", Imf::FLOAT, offsetof(ForeignSample, g)});
        if (!grey_) channels.push_back({"B", Imf::FLOAT, offsetof(ForeignSample, b)});
        bool halves = true;
        for (std::size_t c = 2; c < channels.size(); ++c)
            halves = halves && list[channels[c].name].type == Imf::HALF;
        image_.header.color_storage = halves ? ColorStorage::kFloat16 : ColorStorage::kFloat32;
        if (has_back_) channels.push_back({"ZBack", Imf::FLOAT, offsetof(ForeignSample, z_back)});
        return channels;
    }

    void start_header() {
        image_.header.width = file_.width();
        image_.header.height = file_.height();
        image_.header.draws.emplace_back().name = "deep image";
    }

    void take_row(DeepRow<ForeignSample>& row, int y) {
        ForeignSample* next = row.records().data();
        for (std::size_t x = 0; x < row.counts().size(); ++x) {
            const std::uint32_t count = row.counts()[x];
            if (has_back_) check_volumes({next, next + count}, x, static_cast<std::size_t>(y));
            for (std::uint32_t k = 0; k < count; ++k) take(*next++, x, static_cast<std::size_t>(y));
            image_.start.push_back(static_cast<std::uint32_t>(image_.fragments.size()));
        }
    }

    void take(const ForeignSample& s, std::size_t x, std::size_t y) {
        if (!(s.z >= 0)) fail_at(x, y, fmt::format("Z is {}; it must be a distance of 0 or more", s.z));
        float alpha = s.a + 0.0f;
        if (alpha > 1 && alpha <= 1 + kAlphaSlack) {
            alpha = 1;
            ++lowered_alphas_;
        }
        if (!(alpha >= 0 && alpha <= 1))
            fail_at(x, y,
                    fmt::format("A is {}; it must be from 0 to 1 (to 1 + 2^-10, which is taken as 1)", s.a));
        const float green = grey_ ? s.r : s.g;
        const float blue = grey_ ? s.r : s.b;
        if (!std::isfinite(s.r) || !std::isfinite(green) || !std::isfinite(blue))
            fail_at(x, y, fmt::format("its colour is {}, {}, {}; it must be finite", s.r, green, blue));
        if (std::isinf(s.z))
            infinite_ = true;
        else
            largest_ = std::max(largest_, s.z);
        image_.fragments.push_back({s.z + 0.0f, s.r, green, blue, alpha, static_cast<std::uint16_t>(x),
                                    static_cast<std::uint16_t>(y),
                                    static_cast<std::uint32_t>(image_.fragments.size()) & ~kBackFacing, 1,
                                    0});
    }

    // A volume without another sample in it composites like a surface; one with would have to be cut there.
    void check_volumes(std::vector<ForeignSample> samples, std::size_t x, std::size_t y) {
        const auto thick = [](const ForeignSample& s) { return s.z_back > s.z; };
        const auto volumes = std::count_if(samples.begin(), samples.end(), thick);
        if (volumes == 0) return;
        volumes_ += static_cast<std::uint64_t>(volumes);
        const auto depths = [](const ForeignSample& s) { return std::pair(s.z, std::max(s.z, s.z_back)); };
        for (const ForeignSample& s : samples)
            if (std::isnan(s.z)) fail_at(x, y, "Z is nan; it must be a distance of 0 or more");
        std::sort(samples.begin(), samples.end(),
                  [&](const ForeignSample& a, const ForeignSample& b) { return depths(a) < depths(b); });
        for (std::size_t i = 1; i < samples.size(); ++i) {
            const bool starts_together =
                samples[i - 1].z == samples[i].z && (thick(samples[i - 1]) || thick(samples[i]));
            if (samples[i - 1].z_back > samples[i].z || starts_together)
                fail_at(x, y,
                        fmt::format("the volume from {} to {} overlaps the sample at {}; only volumes "
                                    "without another sample in them can be taken as surfaces: split "
                                    "them first (a tidy deep image has none)",
                                    samples[i - 1].z, std::max(samples[i - 1].z, samples[i - 1].z_back),
                                    samples[i].z));
        }
    }

    // By a power of two, so that order and ties stay exactly as they are.
    void scale_depths() {
        const auto too_far = [&](float z) { return infinite_ ? z >= 1 : z > 1; };
        while (too_far(std::ldexp(largest_, -exponent_))) ++exponent_;
        if (exponent_ != 0 || infinite_) {
            for (Fragment& f : image_.fragments) {
                const float z = std::isinf(f.z) ? 1.0f : std::ldexp(f.z, -exponent_);
                if (!std::isinf(f.z) && std::ldexp(z, exponent_) != f.z)
                    fail_at(f.x, f.y,
                            fmt::format("Z is {} where others are {}: together they exceed the "
                                        "range of a float; remove one of them",
                                        f.z, largest_));
                f.z = z;
            }
        }
        image_.header.scene = fmt::format("deep image, depth is Z * 2^-{}", exponent_);
    }

    void add_notes() {
        image_.notes.push_back(
            fmt::format("depth is Z * 2^-{}{}", exponent_, infinite_ ? ", 1 where Z is infinite" : ""));
        if (volumes_ != 0)
            image_.notes.push_back(
                fmt::format("{} samples are volumes (ZBack > Z); none overlaps another sample, so each is "
                            "taken as a surface at Z",
                            volumes_));
        if (lowered_alphas_ != 0)
            image_.notes.push_back(fmt::format(
                "{} alphas lie above 1 by no more than 2^-10 and are taken as 1", lowered_alphas_));
    }

    DeepExrFile& file_;
    ForeignDeepImage image_;
    bool grey_ = false;
    bool has_back_ = false;
    bool infinite_ = false;
    float largest_ = 0;  // finite depth
    int exponent_ = 0;
    std::uint64_t volumes_ = 0;
    std::uint64_t lowered_alphas_ = 0;
};

}  // namespace

ForeignDeepImage read_foreign_deep_exr(DeepExrFile& file) {
    return ForeignReader(file).run();
}

}  // namespace ropsim
