// Where the parts of the picture of error against bytes lie.
#pragma once

#include "analysis/label_placement.h"
#include "analysis/tradeoff.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace ropsim {

// The two lines of a panel, as the key calls them.
using TradeoffFronts = std::array<const char*, 2>;
inline constexpr TradeoffFronts kTradeoffFronts = {"none has less of both", "the same without lists' pools"};
// Where bytes stand beside others.
inline constexpr TradeoffFronts kTradeoffFrontsBeside = {"measured: none has less of both",
                                                         "the same in the worst case"};

struct TradeoffMark {
    double bytes = 0;
    double error = 0;
    bool front = false;
    bool fixed_front = false;           // of the second line
    double beside = 0;                  // other bytes at the same error; 0: none
    std::size_t family = 0;             // of technique_families()
    const std::string* name = nullptr;  // the technique

    bool named() const { return front || fixed_front; }
    // Where the second line goes through.
    double second() const { return beside > 0 ? beside : bytes; }
};

// What a scene's panel shows and where it lies; pixels with y up, as gnuplot's screen has it.
struct TradeoffPanel {
    const TradeoffScene* scene = nullptr;
    std::vector<TradeoffMark> marks;  // ascending in bytes, then descending in error
    PlotBox box;                      // of the axes
    double bytes_low = 1, bytes_high = 10;
    double error_low = 1, error_high = 10;
    bool zero = false;  // some error is 0 and stands on the floor

    PicturePoint place(const TradeoffMark& mark) const;
};

// The whole picture.
struct TradeoffSheet {
    double width = 0, height = 0;
    double key_height = 0;   // at the bottom
    const char* bytes = "";  // what the axis is called
    TradeoffFronts fronts = kTradeoffFronts;
    std::vector<TradeoffPanel> panels;
    std::vector<std::size_t> families;  // that have a mark, for the key
};

// A panel for each scene with a result, two side by side, and the key below. `tradeoff` must outlive the
// sheet.
TradeoffSheet tradeoff_sheet(const Tradeoff& tradeoff);

// Where the entries of the key are, fronts first, then families.
std::vector<PicturePoint> key_places(const TradeoffSheet& sheet);

}  // namespace ropsim
