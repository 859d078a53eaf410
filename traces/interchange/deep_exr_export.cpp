// Writes a trace as a deep OpenEXR file: a deep part of fragments and a flat part of the opaque layer.
#include "base/atomic_file.h"
#include "base/error.h"
#include "traces/interchange/deep_exr.h"
#include "traces/interchange/deep_exr_file.h"
#include "traces/interchange/deep_exr_records.h"
#include "traces/trace.h"
#include "traces/trace_header.h"

#include <limits>
#include <numeric>

#include <ImfChannelList.h>
#include <ImfDeepImageStateAttribute.h>
#include <ImfDeepScanLineOutputPart.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

namespace ropsim {

namespace {

constexpr std::uint64_t kLargestRowBytes = std::numeric_limits<std::int32_t>::max() / 2;  // OpenEXR's ints

Imf::Header fragment_header(const TraceReader& reader) {
    const TraceHeader& trace = reader.header();
    Imf::Header header(trace.width, trace.height);
    header.setName(kFragmentPart);
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = Imf::ZIPS_COMPRESSION;
    for (const DeepChannel& channel : fragment_channels(trace))
        header.channels().insert(channel.name, Imf::Channel(channel.type));
    Imf::addDeepImageState(header, Imf::DIS_MESSY);
    header.insert(kDeepHeaderAttribute, Imf::StringAttribute(header_text(trace, kTileSize)));
    header.insert(kDeepHashAttribute, Imf::StringAttribute(reader.hash()));
    return header;
}

Imf::Header opaque_header(const TraceHeader& trace) {
    Imf::Header header(trace.width, trace.height);
    header.setName(kOpaquePart);
    header.setType(Imf::SCANLINEIMAGE);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const std::string& name : opaque_channels(trace.samples))
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    return header;
}

// The fragments of some rows of pixels, grouped by row.
struct Band {
    int first_row, last_row;
    FragmentChunk content;
    std::vector<std::uint32_t> orders;     // of each: its place in the whole trace
    std::vector<std::uint32_t> row_start;  // into `by_row`, and the end
    std::vector<std::uint32_t> by_row;     // indices into `content`, arrival order within a row
};

// Only a pass over everything tells a fragment's place in the trace.
void read_band(TraceReader& reader, Band& band) {
    const TraceHeader& header = reader.header();
    FragmentChunk chunk;
    std::uint64_t arrived = 0;
    band.row_start.assign(static_cast<std::size_t>(band.last_row - band.first_row) + 1, 0);
    reader.rewind();
    while (reader.next_raw(chunk)) {
        for (std::size_t i = 0; i < chunk.size(); ++i, ++arrived) {
            const Fragment& f = chunk.fragments[i];
            if (f.y < band.first_row || f.y >= band.last_row) continue;
            band.content.fragments.push_back(f);
            if (header.depth_slopes) band.content.slopes.push_back(chunk.slopes[i]);
            if (header.materials) band.content.materials.push_back(chunk.materials[i]);
            band.orders.push_back(static_cast<std::uint32_t>(arrived));
            ++band.row_start[static_cast<std::size_t>(f.y - band.first_row) + 1];
        }
    }
    std::partial_sum(band.row_start.begin(), band.row_start.end(), band.row_start.begin());
    std::vector<std::uint32_t> next(band.row_start.begin(), band.row_start.end() - 1);
    band.by_row.resize(band.content.size());
    for (std::uint32_t i = 0; i < band.content.size(); ++i)
        band.by_row[next[static_cast<std::size_t>(band.content.fragments[i].y - band.first_row)]++] = i;
}

class FragmentPart {
 public:
    FragmentPart(TraceReader& reader, Imf::MultiPartOutputFile& file)
        : reader_(reader),
          header_(reader.header()),
          part_(file, 0),
          row_(0, header_.width, fragment_channels(header_)) {
        part_.setFrameBuffer(row_.frame());
        for (const DeepChannel& channel : fragment_channels(header_))
            sample_bytes_ += stored_bytes(channel.type);
    }

    void write(std::uint64_t band_fragments) {
        const int tile_rows = tiles_across(header_.height);
        for (int first = 0; first < tile_rows;) {
            int last = first;
            std::uint64_t total = 0;
            do total += tile_row_fragments(last++);
            while (last < tile_rows && total + tile_row_fragments(last) <= band_fragments);
            Band band{first * kTileSize, std::min(last * kTileSize, header_.height), {}, {}, {}, {}};
            read_band(reader_, band);
            for (int y = band.first_row; y < band.last_row; ++y) write_row(band, y);
            first = last;
        }
    }

 private:
    std::uint64_t tile_row_fragments(int tile_row) const {
        const auto across = static_cast<std::ptrdiff_t>(tiles_across(header_.width));
        const auto first = reader_.tile_fragments().begin() + tile_row * across;
        return std::accumulate(first, first + across, std::uint64_t{0});
    }

    void write_row(const Band& band, int y) {
        const auto row = static_cast<std::size_t>(y - band.first_row);
        const std::uint32_t* const begin = band.by_row.data() + band.row_start[row];
        const std::uint32_t* const end = band.by_row.data() + band.row_start[row + 1];
        if (static_cast<std::uint64_t>(end - begin) * sample_bytes_ > kLargestRowBytes)
            throw UserError(reader_.path(),
                            fmt::format("row {} holds {} fragments, more than OpenEXR can; cut "
                                        "the trace with 'trace cut'",
                                        y, end - begin));
        std::vector<std::uint32_t>& counts = row_.counts();
        std::fill(counts.begin(), counts.end(), 0u);
        for (const std::uint32_t* i = begin; i != end; ++i) ++counts[band.content.fragments[*i].x];
        row_.allocate();
        next_.resize(counts.size());
        std::exclusive_scan(counts.begin(), counts.end(), next_.begin(), 0u);
        for (const std::uint32_t* i = begin; i != end; ++i)
            row_.records()[next_[band.content.fragments[*i].x]++] =
                to_record(header_, band.content, *i, band.orders[*i]);
        part_.writePixels(1);
    }

    TraceReader& reader_;
    const TraceHeader& header_;
    Imf::DeepScanLineOutputPart part_;
    DeepRow<DeepRecord> row_;
    std::vector<std::uint32_t> next_;
    std::uint64_t sample_bytes_ = 0;
};

void write_opaque(const TraceHeader& header, Imf::MultiPartOutputFile& file) {
    Imf::OutputPart part(file, 1);
    // OpenEXR only reads through these pointers; its frame buffer is one type for both directions.
    part.setFrameBuffer(opaque_frame(header, const_cast<OpaqueLayer&>(*header.opaque)));
    part.writePixels(header.height);
}

}  // namespace

void export_deep_exr(const std::string& trace_path, const std::string& exr_path,
                     std::uint64_t band_fragments) {
    TraceReader reader(trace_path);
    if (reader.fragment_count() > std::uint64_t{1} << 32)
        throw UserError(trace_path,
                        fmt::format("holds {} fragments; the channel 'order' of a deep OpenEXR file "
                                    "numbers up to 2^32; cut the trace with 'trace cut'",
                                    reader.fragment_count()));
    AtomicFile target(exr_path);
    try {
        std::vector<Imf::Header> headers{fragment_header(reader)};
        if (reader.header().opaque) headers.push_back(opaque_header(reader.header()));
        Imf::MultiPartOutputFile file(target.temporary_path().c_str(), headers.data(),
                                      static_cast<int>(headers.size()), false, 0);
        FragmentPart(reader, file).write(band_fragments);
        if (reader.header().opaque) write_opaque(reader.header(), file);
    } catch (const UserError&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        throw UserError(exr_path, fmt::format("cannot write OpenEXR ({})", error.what()));
    }
    target.commit();
}

}  // namespace ropsim
