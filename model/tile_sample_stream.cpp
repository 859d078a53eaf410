#include "model/tile_sample_stream.h"

#include "base/error.h"
#include "rop/operation_log.h"

#include <algorithm>
#include <utility>

namespace ropsim {

SampleStream::SampleStream(int partition, const SamplePlan& plan, const MachineConfig& config,
                           const Frame& frame, const SampleSquares& squares, bool timed)
    : partition_(partition),
      plan_(plan),
      config_(config),
      squares_(squares),
      timed_(timed),
      cached_(config, frame.surfaces(),
              compressed_surfaces(config, frame.surfaces(), frame.operation().declaration(),
                                  frame.initial_pixels(), partition)),
      share_(share_of(config)),
      front_end_(share_, frame.surfaces(), std::vector<CachedPartition*>(config.partitions, &cached_)),
      operated_(kBySurface + 4 * static_cast<std::size_t>(frame.surfaces().surfaces())),
      counted_(operated_.size()),
      rows_(squares.size()) {
    if (timed_ && plan_.whole()) {
        part_ = SampleBatch::Part::kMeasured;
        stretches_.emplace_back();
    }
    next_stretch_ = plan_.whole() ? 0 : plan_.first_quad(partition_, 0);
}

// Everything up to now.
void SampleStream::count(SampleRow& row) const {
    row = operated_;
    const RopCacheStatistics& c = cached_.cache().statistics();
    row[kHits] = static_cast<double>(c.sector_hits);
    row[kMisses] = static_cast<double>(c.sector_misses);
    row[kAllocations] = static_cast<double>(c.line_allocations);
    row[kEvictions] = static_cast<double>(c.line_evictions);
    row[kSectorsWritten] = static_cast<double>(c.sectors_written_back);
    row[kBytesWritten] = static_cast<double>(c.bytes_written_back);
    row[kFillsAvoided] = static_cast<double>(c.fills_avoided);
    const BytesByCause& pins = cached_.pins();
    for (std::size_t s = 0; s < pins.size(); ++s) {
        std::uint64_t read = 0;
        std::uint64_t write = 0;
        for (const CauseBytes& cause : pins[s]) {
            read += cause.read;
            write += cause.write;
        }
        row[kBySurface + 4 * s] = static_cast<double>(read);
        row[kBySurface + 4 * s + 1] = static_cast<double>(write);
        row[kPinReads] += static_cast<double>(read);
        row[kPinWrites] += static_cast<double>(write);
    }
}

SampleRow SampleStream::total() const {
    SampleRow row;
    count(row);
    return row;
}

void SampleStream::change_square(std::size_t square) {
    count(now_);
    if (square_ != kNoSquare) {
        SampleRow& row = rows_[square_];
        if (row.empty()) row.resize(now_.size());
        for (std::size_t c = 0; c < now_.size(); ++c) row[c] += now_[c] - counted_[c];
    }
    std::swap(counted_, now_);
    square_ = square;
}

void SampleStream::take(const QuadOperation& q, const QuadBatch& batch) {
    // Quads of a lower resolution have tiles of their own.
    const std::size_t tile = q.quad_id / 16;
    const std::size_t square = squares_.square_of(tile);
    if (square != square_) change_square(square);
    if (timed_) add_to_stretch(q, batch);
    front_end_.read(q, batch);
    if (reaches_partition(q)) cached_.operate(q, batch);
    ++position_;
    ++operated_[kQuads];
    operated_[kLines] += q.line_count;
    operated_[kUnitCycles] += q.interval;
    const auto pixels = static_cast<double>(count_elements(q.pixels));
    if (q.kind == QuadKind::kDraw) {
        operated_[kLaneCycles] += q.shader_lane_cycles;
        operated_[kPixels] += pixels;
    } else if (q.kind == QuadKind::kResolve) {
        operated_[kResolved] += pixels;
    }
    const LineAccess* lines = batch.lines[q.partition].data() + q.first_line;
    for (std::uint32_t l = 0; l < q.line_count; ++l) {
        const std::size_t at = kBySurface + std::size_t{4} * lines[l].surface;
        operated_[at + 2] +=
            static_cast<double>(count_elements(lines[l].read_sectors) * config_.cache.sector_bytes);
        for (const std::uint64_t word : lines[l].write_bytes.word)
            operated_[at + 3] += static_cast<double>(count_elements(word));
    }
}

void SampleStream::add_to_stretch(const QuadOperation& q, const QuadBatch& batch) {
    if (!plan_.whole() && !in_stretch_) {
        if (position_ != next_stretch_) return;
        begin_stretch();
    }
    // What the time of a stretch is for: counted before its first measured quad and after its last.
    if (!plan_.whole() && left_ == 0) {
        if (part_ == SampleBatch::Part::kTail) {
            finish_part();
            add_gap();
            in_stretch_ = false;
            next_stretch_ = std::max(position_ + 1, plan_.first_quad(partition_, stretches_.size()));
            return;
        }
        const bool warm = part_ == SampleBatch::Part::kWarm;
        finish_part();
        SampleRow now = total();
        SampleRow& measured = stretches_.back().measured;
        if (warm)
            measured = std::move(now);
        else
            for (std::size_t c = 0; c < now.size(); ++c) measured[c] = now[c] - measured[c];
        enter(warm ? SampleBatch::Part::kMeasured : SampleBatch::Part::kTail);
    }
    // What is culled ends before the partition: a stretch must end where everything before it is written.
    if (part_ == SampleBatch::Part::kTail && !reaches_partition(q)) return;
    copy(q, batch);
    --left_;
}

void SampleStream::begin_stretch() {
    in_stretch_ = true;
    stretches_.push_back({cached_.cache(), {}});
    enter(SampleBatch::Part::kWarm);
}

void SampleStream::enter(SampleBatch::Part part) {
    part_ = part;
    left_ = part == SampleBatch::Part::kWarm       ? SamplePlan::kWarm
            : part == SampleBatch::Part::kMeasured ? SamplePlan::kMeasured
                                                   : SamplePlan::kTail;
}

void SampleStream::finish_part() {
    open_.back()->last = true;
    if (part_ != SampleBatch::Part::kTail) return;
    ready_.insert(ready_.end(), open_.begin(), open_.end());
    open_.clear();
}

// Quads without lines: with the slots full of them nothing holds the cache, so that the next stretch can put
// its own state there.
void SampleStream::add_gap() {
    SampleBatch* gap = take_empty(SampleBatch::Part::kGap, 0);
    QuadOperation q;
    q.kind = QuadKind::kCopy;  // needs no shading
    q.partition = static_cast<std::uint8_t>(partition_);
    gap->quads.assign(std::size_t{2} * config_.quads_in_flight, q);
    gap->last = true;
    ready_.push_back(gap);
}

void SampleStream::copy(const QuadOperation& q, const QuadBatch& batch) {
    constexpr std::size_t kLargest = 4096;  // quads, where nothing ends a batch
    if (open_.empty() || open_.back()->part != part_ || open_.back()->pass != batch.pass ||
        open_.back()->quads.size() >= kLargest)
        open_.push_back(take_empty(part_, batch.pass));
    SampleBatch& to = *open_.back();
    const auto p = static_cast<std::size_t>(partition_);
    QuadOperation& copied = to.quads.emplace_back(q);
    // With those that the depth unit reads.
    copied.first_line = static_cast<std::uint32_t>(to.lines[p].size()) + q.depth_lines;
    const LineAccess* lines = batch.lines[p].data() + q.first_line - q.depth_lines;
    for (std::uint32_t l = 0; l < q.depth_lines + q.line_count; ++l) {
        LineAccess& line = to.lines[p].emplace_back(lines[l]);
        if (line.values == LineAccess::kNoValues) continue;
        const auto from = batch.values[p].begin() + line.values;
        line.values = static_cast<std::uint32_t>(to.values[p].size());
        to.values[p].insert(to.values[p].end(), from, from + config_.cache.line_bytes);
    }
    if (!plan_.whole() || to.quads.size() < kLargest) return;
    ready_.insert(ready_.end(), open_.begin(), open_.end());
    open_.clear();
}

void SampleStream::end() {
    // The flush counts with the last square: it is a cacheful, the same in every partition.
    cached_.flush();
    change_square(kNoSquare);
    ended_ = true;
    if (plan_.whole()) {
        ready_.insert(ready_.end(), open_.begin(), open_.end());
        open_.clear();
    } else if (in_stretch_) {
        stretches_.pop_back();  // cut off by the end of the frame
        empty_.insert(empty_.end(), open_.begin(), open_.end());
        open_.clear();
    }
}

RopCache SampleStream::take_cache(std::size_t number) {
    CHECK(stretches_[number].cache.has_value(), "stretch {} of partition {}", number, partition_);
    RopCache cache = std::move(*stretches_[number].cache);
    stretches_[number].cache.reset();
    return cache;
}

SampleBatch* SampleStream::take_empty(SampleBatch::Part part, std::uint8_t pass) {
    if (empty_.empty()) {
        owned_.push_back(std::make_unique<SampleBatch>());
        empty_.push_back(owned_.back().get());
    }
    SampleBatch* batch = empty_.back();
    empty_.pop_back();
    batch->clear();
    batch->lines.resize(config_.partitions);
    batch->values.resize(config_.partitions);
    batch->pass = pass;
    batch->part = part;
    batch->last = false;
    return batch;
}

SampleBatch* SampleStream::next() {
    if (ready_.empty()) return nullptr;
    SampleBatch* batch = ready_.front();
    ready_.pop_front();
    return batch;
}

void SampleStream::release(SampleBatch* batch) {
    empty_.push_back(batch);
}

SampleFeeder::SampleFeeder(Frame& frame, std::vector<std::unique_ptr<SampleStream>>& streams)
    : frame_(frame),
      streams_(streams),
      of_partition_(static_cast<std::size_t>(frame.surfaces().partitions()), nullptr) {
    for (const auto& stream : streams_)
        of_partition_[static_cast<std::size_t>(stream->partition())] = stream.get();
}

bool SampleFeeder::advance() {
    if (ended_) return false;
    if (!frame_.advance(batch_)) {
        ended_ = true;
        for (const auto& stream : streams_) stream->end();
        return false;
    }
    for (const QuadOperation& q : batch_.quads)
        if (SampleStream* stream = of_partition_[q.partition]) stream->take(q, batch_);
    return true;
}

}  // namespace ropsim
