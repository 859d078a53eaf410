// One row of a deep image: its samples as records in memory, and OpenEXR's frame buffer over them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include <ImfDeepFrameBuffer.h>
#include <ImfPixelType.h>

namespace ropsim {

// A channel of the file and where its value lies in a record.
struct DeepChannel {
    std::string name;
    Imf::PixelType type;
    std::size_t offset;
};

inline std::size_t stored_bytes(Imf::PixelType type) {
    return type == Imf::HALF ? 2 : 4;
}

template <typename Record>
class DeepRow {
 public:
    // `left` is the x of the first pixel in the file's coordinates.
    DeepRow(std::int64_t left, int width, const std::vector<DeepChannel>& channels)
        : counts_(static_cast<std::size_t>(width)), pointers_(channels.size()) {
        // OpenEXR addresses pixels from x = 0 of its own plane, which lies outside the array when the data
        // window does not start there: Slice::Make does that arithmetic. A row stride of 0 puts every row at
        // the same place.
        const auto base = [&](void* first, std::size_t stride) {
            return Imf::Slice::Make(Imf::UINT, first, {static_cast<int>(left), 0}, width, 1, stride).base;
        };
        frame_.insertSampleCountSlice(
            Imf::Slice(Imf::UINT, base(counts_.data(), sizeof(counts_[0])), sizeof(counts_[0]), 0));
        for (std::size_t c = 0; c < channels.size(); ++c) {
            pointers_[c].resize(counts_.size());
            offsets_.push_back(channels[c].offset);
            frame_.insert(channels[c].name,
                          Imf::DeepSlice(channels[c].type, base(pointers_[c].data(), sizeof(char*)),
                                         sizeof(char*), 0, sizeof(Record)));
        }
    }
    DeepRow(const DeepRow&) = delete;
    DeepRow& operator=(const DeepRow&) = delete;

    const Imf::DeepFrameBuffer& frame() const { return frame_; }
    // Samples of each pixel.
    std::vector<std::uint32_t>& counts() { return counts_; }
    std::uint64_t total() const { return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}); }
    // The samples, pixel after pixel.
    std::vector<Record>& records() { return records_; }
    // To be called when the counts are known, before records are filled.
    void allocate() {
        records_.reserve(
            std::max<std::size_t>(total(), 1));  // data() of an empty row is no null pointer either
        records_.resize(total());
        for (std::size_t c = 0; c < pointers_.size(); ++c) {
            char* next = reinterpret_cast<char*>(records_.data()) + offsets_[c];
            for (std::size_t x = 0; x < counts_.size(); ++x) {
                pointers_[c][x] = next;
                next += counts_[x] * sizeof(Record);
            }
        }
    }

 private:
    std::vector<std::uint32_t> counts_;
    std::vector<Record> records_;
    std::vector<std::vector<char*>> pointers_;
    std::vector<std::size_t> offsets_;
    Imf::DeepFrameBuffer frame_;
};

}  // namespace ropsim
