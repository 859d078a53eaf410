// Writes deep OpenEXR files as other programs do, sample by sample.
#pragma once

#include "traces/interchange/deep_exr_row.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <ImfChannelList.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfHeader.h>
#include <ImfPartType.h>

namespace ropsim {

// A deep image under construction: records at pixels of a data window.
template <typename Record>
struct DeepPicture {
    Imath::Box2i window;
    std::vector<DeepChannel> channels;
    std::map<std::pair<int, int>, std::vector<Record>> samples;  // by (x, y)
    Imf::Compression compression = Imf::ZIPS_COMPRESSION;

    Imf::Header header() const {
        const Imath::Box2i display({0, 0}, {63, 63});
        Imf::Header result(display, window);
        result.setType(Imf::DEEPSCANLINE);
        result.compression() = compression;
        for (const DeepChannel& channel : channels)
            result.channels().insert(channel.name, Imf::Channel(channel.type));
        return result;
    }
    template <typename File>
    void write_rows(File& file) const {
        const int width = window.max.x - window.min.x + 1;
        DeepRow<Record> row(window.min.x, width, channels);
        file.setFrameBuffer(row.frame());
        for (int y = window.min.y; y <= window.max.y; ++y) {
            std::vector<Record> all;
            for (int x = window.min.x; x <= window.max.x; ++x) {
                const auto found = samples.find({x, y});
                row.counts()[static_cast<std::size_t>(x - window.min.x)] =
                    found == samples.end() ? 0 : static_cast<std::uint32_t>(found->second.size());
                if (found != samples.end()) all.insert(all.end(), found->second.begin(), found->second.end());
            }
            row.allocate();
            std::copy(all.begin(), all.end(), row.records().begin());
            file.writePixels(1);
        }
    }
    void write(const std::string& path, const Imf::Header& with) const {
        Imf::DeepScanLineOutputFile file(path.c_str(), with, 0);
        write_rows(file);
    }
    void write(const std::string& path) const { write(path, header()); }
};

// What compositing programs write.
struct PlainSample {
    float z = 0, r = 0, g = 0, b = 0, a = 0, z_back = 0;
};

inline DeepPicture<PlainSample> plain_picture(int left, int top, int width, int height) {
    DeepPicture<PlainSample> picture;
    picture.window = {{left, top}, {left + width - 1, top + height - 1}};
    picture.channels = {{"Z", Imf::FLOAT, offsetof(PlainSample, z)},
                        {"R", Imf::FLOAT, offsetof(PlainSample, r)},
                        {"G", Imf::FLOAT, offsetof(PlainSample, g)},
                        {"B", Imf::FLOAT, offsetof(PlainSample, b)},
                        {"A", Imf::FLOAT, offsetof(PlainSample, a)}};
    return picture;
}

}  // namespace ropsim
