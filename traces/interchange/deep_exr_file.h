// A deep OpenEXR file opened for reading, row by row, with every claim checked before memory is taken for it.
#pragma once

#include "base/error.h"
#include "traces/interchange/deep_exr_row.h"
#include "traces/trace.h"

#include <cstdint>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <ImfDeepScanLineInputPart.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>

namespace ropsim {

class DeepExrFile {
 public:
    // Opens the first deep scanline part. Throws UserError, naming what the file holds instead.
    explicit DeepExrFile(const std::string& path);

    const std::string& path() const { return path_; }
    const Imf::Header& header() const { return file_->header(part_number_); }
    Imf::MultiPartInputFile& parts() { return *file_; }
    // A part by its name.
    std::optional<int> part(const std::string& name) const;
    int left() const { return left_; }  // the data window's corner
    int top() const { return top_; }
    int width() const { return width_; }
    int height() const { return height_; }
    std::uint64_t bytes() const { return bytes_; }  // of the file
    // Of the part, as its chunks claim; read_row holds each row to it. The file is large enough for them.
    std::uint64_t samples() const;
    [[noreturn]] void fail(const std::string& what) const { throw UserError(path_, what); }

    // Rows are read into `row` from here on.
    template <typename Record>
    void attach(DeepRow<Record>& row) {
        input_->setFrameBuffer(row.frame());
    }
    // Row y, 0 to height - 1, into the attached one.
    template <typename Record>
    void read_row(int y, DeepRow<Record>& row) {
        input_->readPixelSampleCounts(top_ + y);
        if (row.total() * sample_bytes_ != row_bytes_[static_cast<std::size_t>(y)])
            fail(fmt::format("row {}: {} samples do not fit its {} bytes; the file is damaged", top_ + y,
                             row.total(), row_bytes_[static_cast<std::size_t>(y)]));
        row.allocate();
        input_->readPixels(top_ + y);
    }

 private:
    std::string path_;
    std::uint64_t bytes_ = 0;
    std::vector<std::uint64_t> row_bytes_;
    std::unique_ptr<Imf::MultiPartInputFile> file_;
    std::unique_ptr<Imf::DeepScanLineInputPart> input_;
    int part_number_ = 0;
    int left_ = 0, top_ = 0, width_ = 0, height_ = 0;
    std::uint64_t sample_bytes_ = 0;
};

// Slices over a trace's opaque layer, as its part in a file has them.
Imf::FrameBuffer opaque_frame(const TraceHeader& header, OpaqueLayer& layer);

// Calls `work`; OpenEXR's exceptions become UserError with the file's name.
template <typename Work>
auto with_exr_faults(const std::string& path, Work&& work) {
    try {
        return work();
    } catch (const UserError&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        std::string what = error.what();
        for (char& c : what)
            if (c == '\n') c = ' ';
        throw UserError(path, fmt::format("is not a deep OpenEXR file that can be read ({})", what));
    }
}

}  // namespace ropsim
