// A ROP partition's compressed blocks: their states, their fills, and their way to memory.
#include "memory/block_write_back.h"
#include "model/rop_partition.h"

#include <algorithm>
#include <bit>

namespace ropsim {

std::uint32_t RopPartition::decompress_latency(std::uint8_t surface) const {
    return compressed_->memory.codec(surface).decompress_latency();
}

bool RopPartition::compressed_in_memory(const LineAccess& access) {
    return compressed_->memory.holds(access.surface) &&
           compressed_->memory.state(access.surface, access.line_address) ==
               CompressedMemory::State::kCompressed;
}

// One request for the block's bytes, which make the line whole.
void RopPartition::queue_block_fill(std::uint64_t line_address, MemoryRequest request) {
    request.address = compressed_->memory.block_of(line_address);
    request.bytes = compressed_->memory.stored_bytes(request.surface, line_address);
    asked_[request.id << (kMshrShift - kSectorShift)] = wheel_.now();
    request.id = kBlockFill | request.id << kMshrShift | request.bytes / kBlockUnit;
    queue_request(request);
}

// Whether the state of the line's block is here, where one is needed: the tag stage waits for it.
bool RopPartition::look_up_state(const LineAccess& access, StageLabel& reason) {
    if (!compressed_->has_states(access.surface)) return true;
    const int line = cache_.probe(access.line_address, access.surface);
    const std::uint32_t here =
        line == RopCache::kMiss
            ? 0
            : cache_.valid_sectors(line) | cache_.pending_sectors(line, access.read_sectors);
    if ((access.read_sectors & ~here) == 0 || state_known_ == access.line_address) return true;
    reason = StageLabel::kMetadata;
    if (state_pending_) return false;
    const MetadataCache::Traffic traffic = compressed_->metadata->look_up(access.line_address, false);
    queue_metadata(traffic, access.surface, kStateRead);
    state_known_ = access.line_address;
    state_pending_ = traffic.read_bytes != 0;
    return !state_pending_;
}

void RopPartition::queue_metadata(const MetadataCache::Traffic& traffic, std::uint8_t surface,
                                  std::uint32_t id) {
    MemoryRequest request{.surface = surface, .cause = MemoryCause::kMetadata};
    if (traffic.write_bytes != 0) {
        request.address = traffic.write_address;
        request.bytes = traffic.write_bytes;
        request.write = true;
        queue_request(request);
    }
    if (traffic.read_bytes == 0) return;
    request.address = traffic.read_address;
    request.bytes = traffic.read_bytes;
    request.write = false;
    request.id = id | request.bytes / kBlockUnit;
    queue_request(request);
}

// Decides how a block leaves, asks for what that needs, and keeps it until it may be written.
void RopPartition::queue_block(const Eviction& eviction, MemoryCause cause) {
    CompressedMemory& memory = compressed_->memory;
    const auto free = std::ranges::find(leaving_, false, &LeavingBlock::used);
    CHECK(free != leaving_.end());
    const auto id = kLeavingRead | static_cast<std::uint32_t>(free - leaving_.begin()) << kMshrShift;
    LeavingBlock out;
    out.eviction = eviction;
    out.block = memory.block_of(eviction.line_address);
    out.cause = cause;
    if (memory.holds(eviction.surface)) {
        const BlockWriteBack block = write_back_block(cache_, memory, eviction, config_.compression.sticky);
        out.write_bytes = block.write_bytes;
        if (block.tried) out.latency = memory.codec(eviction.surface).compress_latency();
        if (block.repack_bytes != 0) {
            out.latency += decompress_latency(eviction.surface);
            ++out.reads;
            queue_request({.address = out.block,
                           .bytes = block.repack_bytes,
                           .surface = eviction.surface,
                           .cause = MemoryCause::kRepack,
                           .id = id | block.repack_bytes / kBlockUnit});
        }
    }
    if (compressed_->has_states(eviction.surface)) {
        const MetadataCache::Traffic traffic = compressed_->metadata->look_up(eviction.line_address, true);
        queue_metadata(traffic, eviction.surface, id);
        out.reads += traffic.read_bytes != 0 ? 1 : 0;
    }
    if (out.reads == 0 && out.latency == 0) return queue_sectors(eviction, cause);
    out.ready = wheel_.now() / config_.rop_period_ps + out.latency;
    out.used = true;
    *free = out;
    ++leaving_count_;
}

bool RopPartition::leaving(std::uint64_t line_address) const {
    const std::uint64_t block = compressed_->memory.block_of(line_address);
    return std::ranges::any_of(leaving_, [&](const LeavingBlock& l) { return l.used && l.block == block; });
}

void RopPartition::leaving_read_done(std::uint32_t number, std::uint64_t cycle) {
    LeavingBlock& block = leaving_[number];
    CHECK(block.used && block.reads != 0, "leaving block {}", number);
    if (--block.reads == 0) block.ready = cycle + block.latency;
}

void RopPartition::write_leaving_blocks(std::uint64_t cycle) {
    for (LeavingBlock& block : leaving_) {
        if (!block.used || block.reads != 0 || block.ready > cycle) continue;
        if (request_room() < worst_requests_ + (sent_ == cycle ? 1 : 0)) return;
        moved_for_ = std::bit_cast<ByteSource>(block.eviction.writer);
        if (block.write_bytes != 0)
            queue_request({.address = block.block,
                           .bytes = block.write_bytes,
                           .write = true,
                           .surface = block.eviction.surface,
                           .cause = block.cause});
        else
            queue_sectors(block.eviction, block.cause);
        block.used = false;
        --leaving_count_;
    }
}

// When the next block that waits for nothing but time may be written; without room for its requests the next
// one that is sent wakes the partition.
std::uint64_t RopPartition::next_leaving_block() const {
    if (request_room() < worst_requests_) return kNever;
    std::uint64_t next = kNever;
    for (const LeavingBlock& block : leaving_)
        if (block.used && block.reads == 0) next = std::min(next, block.ready);
    return next;
}

bool RopPartition::flushing_metadata() const {
    return compressed_ != nullptr && compressed_->metadata && input_.finished() && input_.empty() &&
           write_head_ == tag_tail_ && !tagging_ && flush_line_ == cache_.line_count() &&
           leaving_count_ == 0 && compressed_->metadata->dirty();
}

// States of several surfaces share a sector: they go to the first.
void RopPartition::flush_metadata() {
    if (!flushing_metadata() || request_room() == 0) return;
    moved_for_ = breakdown_.end_of_frame();
    queue_metadata(compressed_->metadata->write_back(), 0, 0);
}

}  // namespace ropsim
