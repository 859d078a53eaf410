// What a RopsimTrace is behind the C interface: the header while it is gathered, then the writer. Throws
// UserErrors.
#pragma once

#include "base/error.h"
#include "base/parallel.h"
#include "capture/client/ropsim_trace_client.h"
#include "capture/fragment_order.h"
#include "traces/trace.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace ropsim::client {

inline constexpr std::size_t kHeaderBytes = 32;
inline constexpr std::size_t kRecordBytes = sizeof(Fragment);
inline constexpr std::uint32_t kMaxPrimitiveSpan = 1u << 24;
inline constexpr std::size_t kPieceFragments = std::size_t{1} << 16;

// Records in the buffer, arrived and present.
inline std::pair<std::uint64_t, std::uint64_t> record_counts(const void* buffer, std::size_t bytes) {
    if (buffer == nullptr || bytes < kHeaderBytes) return {0, 0};
    std::uint32_t arrived = 0;
    std::memcpy(&arrived, buffer, sizeof arrived);
    return {arrived, std::min<std::uint64_t>(arrived, (bytes - kHeaderBytes) / kRecordBytes)};
}

}  // namespace ropsim::client

struct RopsimTrace {
    std::string path;
    ropsim::TraceHeader header;
    bool bottom_up = false;
    bool finished = false;
    std::unique_ptr<ropsim::TraceWriter> writer;
    std::unique_ptr<ropsim::FragmentOrder> order;
    std::string error;

    [[noreturn]] void fail(const std::string& what) const { throw ropsim::UserError(path, what); }

    void expect_not_begun(const char* what) const {
        if (writer) fail(fmt::format("its {} must come before the first append", what));
    }

    void begin() {
        if (writer) return;
        if (header.draws.empty()) fail("no draw was added; call ropsim_trace_add_draw() before appending");
        writer = std::make_unique<ropsim::TraceWriter>(path, header);
    }

    // What TraceWriter takes for granted, checked, and rows counted from the top.
    void accept(ropsim::Fragment& fragment) const {
        if (fragment.x >= header.width || fragment.y >= header.height)
            fail(fmt::format("a fragment at pixel ({}, {}) is outside the {}x{} image", fragment.x,
                             fragment.y, header.width, header.height));
        if (fragment.draw >= header.draws.size())
            fail(fmt::format("a fragment is of draw {}, but {} were added", fragment.draw,
                             header.draws.size()));
        if (fragment.coverage >= (1u << header.samples))
            fail(fmt::format("a fragment covers samples {:#x}, but a pixel has {}", fragment.coverage,
                             header.samples));
        if (bottom_up) fragment.y = static_cast<std::uint16_t>(header.height - 1 - fragment.y);
    }

    void append_draw(const ropsim::Fragment* fragments, std::size_t count) {
        const auto [low, high] = std::minmax_element(
            fragments, fragments + count, [](const ropsim::Fragment& a, const ropsim::Fragment& b) {
                return ropsim::primitive_number(a) < ropsim::primitive_number(b);
            });
        const std::uint32_t first = ropsim::primitive_number(*low);
        const std::uint32_t last = ropsim::primitive_number(*high);
        const std::uint32_t span = last - first;
        if (span >= ropsim::client::kMaxPrimitiveSpan)
            fail(
                fmt::format("triangle numbers of draw {} span from {} to {}; number them "
                            "consecutively or append at most {} at once",
                            fragments->draw, first, last, ropsim::client::kMaxPrimitiveSpan));
        ropsim::FragmentRecords records;
        records.words.resize(count * ropsim::client::kRecordBytes / sizeof(std::uint32_t));
        std::memcpy(records.words.data(), fragments, count * ropsim::client::kRecordBytes);
        if (!order)
            order = std::make_unique<ropsim::FragmentOrder>(header.width, 1, ropsim::default_threads());
        writer->append(order->sort(records, first, span + 1));
    }

    void append_records(const void* buffer, std::size_t bytes) {
        if (header.samples != 1)
            fail("records hold one spatial sample a pixel; create the trace with samples = 1");
        if (buffer == nullptr || bytes < ropsim::client::kHeaderBytes)
            fail(fmt::format("a record buffer of {} bytes has no header of {}", bytes,
                             ropsim::client::kHeaderBytes));
        const auto [arrived, present] = ropsim::client::record_counts(buffer, bytes);
        if (present < arrived)
            fail(
                fmt::format("{} fragments arrived where {} fit; draw fewer triangles at once or "
                            "give a larger buffer",
                            arrived, present));
        begin();
        if (present == 0) return;
        std::vector<ropsim::Fragment> fragments(present);
        std::memcpy(fragments.data(), static_cast<const char*>(buffer) + ropsim::client::kHeaderBytes,
                    present * ropsim::client::kRecordBytes);
        for (ropsim::Fragment& fragment : fragments) accept(fragment);
        // Numbers are sorted, not fragments: std::stable_sort's buffer knows nothing of their alignment.
        std::vector<std::size_t> by_draw(present);
        std::iota(by_draw.begin(), by_draw.end(), std::size_t{0});
        std::ranges::stable_sort(by_draw, {}, [&](std::size_t i) { return fragments[i].draw; });
        std::vector<ropsim::Fragment> of_draw;
        for (auto first = by_draw.begin(); first != by_draw.end();) {
            const auto draw = fragments[*first].draw;
            of_draw.clear();
            for (; first != by_draw.end() && fragments[*first].draw == draw; ++first)
                of_draw.push_back(fragments[*first]);
            append_draw(of_draw.data(), of_draw.size());
        }
    }

    void append_fragments(const RopsimFragment* given, std::size_t count) {
        begin();
        std::vector<ropsim::Fragment> piece;
        for (std::size_t first = 0; first < count; first += piece.size()) {
            piece.resize(std::min(ropsim::client::kPieceFragments, count - first));
            std::memcpy(piece.data(), given + first, piece.size() * sizeof(ropsim::Fragment));
            for (ropsim::Fragment& fragment : piece) accept(fragment);
            writer->append(piece);
        }
    }

    void set_opaque(const float* rgb, const float* depth) {
        const auto samples = static_cast<std::size_t>(header.samples);
        const auto row = static_cast<std::size_t>(header.width) * samples;
        const auto rows = static_cast<std::size_t>(header.height);
        ropsim::OpaqueLayer layer;
        layer.rgb.reserve(rows * row * 3);
        layer.depth.reserve(rows * row);
        for (std::size_t y = 0; y < rows; ++y) {
            const std::size_t from = bottom_up ? rows - 1 - y : y;
            layer.rgb.insert(layer.rgb.end(), rgb + from * row * 3, rgb + (from + 1) * row * 3);
            layer.depth.insert(layer.depth.end(), depth + from * row, depth + (from + 1) * row);
        }
        header.opaque = std::move(layer);
    }
};
