// A deep OpenEXR file opened for reading, row by row, with every claim checked before memory is taken for it.
#include "traces/interchange/deep_exr_file.h"

#include "traces/interchange/deep_exr_guard.h"
#include "traces/interchange/deep_exr_records.h"

#include <filesystem>
#include <numeric>

#include <ImfChannelList.h>
#include <ImfPartType.h>

namespace ropsim {

DeepExrFile::DeepExrFile(const std::string& path) : path_(path) {
    const std::vector<ExrPartShape> shapes = check_exr_claims(path);
    bytes_ = std::filesystem::file_size(path);
    file_ = std::make_unique<Imf::MultiPartInputFile>(path.c_str(), 0, false);
    int found = -1;
    bool tiled = false;
    for (int i = file_->parts() - 1; i >= 0; --i) {
        const Imf::Header& part = file_->header(i);
        if (part.hasType() && part.type() == Imf::DEEPSCANLINE) found = i;
        tiled = tiled || (part.hasType() && part.type() == Imf::DEEPTILE);
    }
    if (found < 0 && tiled)
        fail(
            "holds deep tiles; convert it to deep scanlines, e.g. with 'oiiotool IN.exr --scanline -o "
            "OUT.exr'");
    if (found < 0) fail("holds no deep image; fragments are read from deep scanline parts only");
    part_number_ = found;
    const Imath::Box2i window = header().dataWindow();
    left_ = window.min.x;
    top_ = window.min.y;
    width_ = window.max.x - window.min.x + 1;
    height_ = window.max.y - window.min.y + 1;
    if (static_cast<std::size_t>(found) < shapes.size())
        row_bytes_ = shapes[static_cast<std::size_t>(found)].row_bytes;
    if (row_bytes_.size() != static_cast<std::size_t>(height_)) fail("contradicts itself in its headers");
    const Imf::ChannelList& channels = header().channels();
    for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
        if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1)
            fail(fmt::format("channel {} is subsampled; write it at full resolution", channel.name()));
        sample_bytes_ += stored_bytes(channel.channel().type);
    }
    if (sample_bytes_ == 0) fail("has no channels");
    input_ = std::make_unique<Imf::DeepScanLineInputPart>(*file_, found);
}

std::optional<int> DeepExrFile::part(const std::string& name) const {
    for (int i = 0; i < file_->parts(); ++i)
        if (file_->header(i).hasName() && file_->header(i).name() == name) return i;
    return std::nullopt;
}

std::uint64_t DeepExrFile::samples() const {
    return std::accumulate(row_bytes_.begin(), row_bytes_.end(), std::uint64_t{0}) / sample_bytes_;
}

Imf::FrameBuffer opaque_frame(const TraceHeader& header, OpaqueLayer& layer) {
    Imf::FrameBuffer frame;
    const auto samples = static_cast<std::size_t>(header.samples);
    const auto width = static_cast<std::size_t>(header.width);
    const std::vector<std::string> names = opaque_channels(header.samples);
    for (std::size_t m = 0; m < samples; ++m) {
        for (std::size_t c = 0; c < 3; ++c)
            frame.insert(names[4 * m + c],
                         Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&layer.rgb[3 * m + c]),
                                    3 * samples * sizeof(float), 3 * samples * width * sizeof(float)));
        frame.insert(names[4 * m + 3], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&layer.depth[m]),
                                                  samples * sizeof(float), samples * width * sizeof(float)));
    }
    return frame;
}

}  // namespace ropsim
