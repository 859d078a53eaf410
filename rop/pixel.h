// A pixel's state as an operation sees it: fetch names the bytes asked of memory, load and store move values
// and convert them to and from the stored format.
#pragma once

#include "rop/datapath.h"
#include "rop/declaration.h"
#include "rop/node_pool.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace ropsim {

// Elements of one surface that an operation read from and wrote to memory. For a pool, the node written.
// Without initialisers: an operation's are cleared one by one (see OperationOf::run).
struct SurfaceAccess {
    std::uint64_t read;  // bit e: element e
    std::uint64_t write;
};
using PixelAccess = std::array<SurfaceAccess, kMaxTechniqueSurfaces>;

template <class D>
struct Rgb {
    typename D::Real r, g, b;
};

inline std::uint64_t all_elements(int count) {
    return count >= 64 ? ~0ull : (1ull << count) - 1;
}

// Plain: values only. `words` is the pixel's functional state (one 32-bit word a channel, already rounded).
class PlainPixel {
 public:
    using D = PlainDatapath;
    PlainPixel(std::uint32_t* words, PixelAccess& access, NodePool* pool)
        : words_(words), access_(access), pool_(pool) {}

    void fetch_all(const Field& f, int elements) { access_[f.surface].read |= all_elements(elements); }
    void fetch_if(bool condition, const Field& f, int element) {
        access_[f.surface].read |= static_cast<std::uint64_t>(condition) << element;
    }

    float load(const Field& f, int element = 0, int channel = 0) const {
        return word_value(words_[f.first_word + f.stride * element + channel]);
    }
    std::uint32_t load_bits(const Field& f, int element = 0, int word = 0) const {
        return words_[f.first_word + f.stride * element + word];
    }
    Rgb<D> load_rgb(const Field& f, int element = 0) const {
        return {load(f, element, 0), load(f, element, 1), load(f, element, 2)};
    }

    // The technique's own word of the pixel, behind the `pixel_words` of its state.
    std::uint32_t constant(int pixel_words) const { return words_[pixel_words]; }

    // From here on fetches may depend on what has been loaded: a second stage, with a latency of its own.
    void next_fetch_stage(bool) {}
    // `value` as it would be read back from the field.
    static float as_stored(const Field& f, float value) {
        return f.format == Format::kFloat32 ? value : stored_value(f.format, value);
    }

    // The words of a field that is alone in its surface, one an element.
    const std::uint32_t* words(const Field& f) const { return words_ + f.first_word; }

    // The words of an element of a field; those of a field of one channel lie side by side.
    std::uint32_t* element_words(const Field& f, int element) {
        return words_ + (f.first_word + std::ptrdiff_t{f.stride} * element);
    }
    // Marks elements first..count-1 as written to memory.
    void write_from(const Field& f, int first, int count) {
        access_[f.surface].write |= all_elements(count) & ~all_elements(first);
    }

    // Marks the whole element as written to memory; the values follow by put.
    void write(const Field& f, int element = 0) { access_[f.surface].write |= 1ull << element; }
    void write_if(bool condition, const Field& f, int element) {
        access_[f.surface].write |= static_cast<std::uint64_t>(condition) << element;
    }
    void put(const Field& f, int element, int channel, float value) {
        if (f.format != Format::kFloat32) value = stored_value(f.format, value);
        words_[f.first_word + f.stride * element + channel] = stored_word(value);
    }
    void put_bits(const Field& f, int element, int word, std::uint32_t value) {
        words_[f.first_word + f.stride * element + word] = value;
    }
    void put_rgb(const Field& f, int element, const Rgb<D>& rgb) {
        if (f.format == Format::kR11G11B10 || f.format == Format::kRgb9e5) [[unlikely]] {
            const auto rounded = stored_rgb(f.format, std::array<float, 3>{rgb.r, rgb.g, rgb.b});
            for (int c = 0; c < 3; ++c)
                words_[f.first_word + f.stride * element + c] =
                    stored_word(rounded[static_cast<std::size_t>(c)]);
            return;
        }
        put(f, element, 0, rgb.r);
        put(f, element, 1, rgb.g);
        put(f, element, 2, rgb.b);
    }
    // A colour converted once, for as many elements as take it.
    using StoredRgb = std::array<std::uint32_t, 3>;
    static StoredRgb converted(const Field& f, const Rgb<D>& rgb) {
        const auto rounded = stored_rgb(f.format, std::array<float, 3>{rgb.r, rgb.g, rgb.b});
        return {stored_word(rounded[0]), stored_word(rounded[1]), stored_word(rounded[2])};
    }
    void put_converted_if(bool condition, const Field& f, int element, const StoredRgb& words) {
        if (condition) std::memcpy(&words_[f.first_word + f.stride * element], words.data(), sizeof words);
    }
    // Predicated forms: the store happens where the condition holds.
    void put_if(bool condition, const Field& f, int element, int channel, float value) {
        if (condition) put(f, element, channel, value);
    }
    void put_rgb_if(bool condition, const Field& f, int element, const Rgb<D>& rgb) {
        if (condition) put_rgb(f, element, rgb);
    }

    // Takes a node from the pool; kNoNode when the pool is full.
    std::uint32_t allocate_node() { return pool_->allocate(); }
    // Marks the whole node as written to memory; the values follow by put on node(index).
    void write_node(const Field& f, std::uint32_t index) { access_[f.surface].write = kNodeWritten | index; }
    PlainPixel node(std::uint32_t index) { return {pool_->words(index), access_, pool_}; }
    // A node of the list is fetched: its address is known only now, so it is a fetch of its own.
    void fetch_node(std::uint32_t index) { pool_->visit(index); }

    static constexpr std::uint64_t kNodeWritten = 1ull << 63;

 private:
    std::uint32_t* words_;
    PixelAccess& access_;
    NodePool* pool_;
};

// Charged: the same on wires, charging conversions, and refusing a load of anything not fetched.
class ChargedPixel {
 public:
    using D = ChargedDatapath;
    // `worst`: predicated accesses count as if they all happened (path enumeration).
    ChargedPixel(std::uint32_t* words, PixelAccess& access, NodePool* pool, bool worst)
        : plain_(words, access, pool), access_(access), pool_(pool), worst_(worst) {}

    void fetch_all(const Field& f, int elements) {
        CHECK(!loaded_, "fetch after a load: the bytes must be named before they are known");
        plain_.fetch_all(f, elements);
    }
    void fetch_if(Wire<bool> condition, const Field& f, int element) {
        CHECK(!loaded_, "fetch after a load: the bytes must be named before they are known");
        plain_.fetch_if(condition.value || worst_, f, element);
        // Elements of predicated fetches may be looked at (and ignored) whatever the predicate.
        predicated_[f.surface] |= 1ull << element;
    }

    Wire<float> load(const Field& f, int element = 0, int channel = 0) {
        check_fetched(f, element);
        return {plain_.load(f, element, channel), conversion(f, stage_ready_)};
    }
    Wire<std::uint32_t> load_bits(const Field& f, int element = 0, int word = 0) {
        check_fetched(f, element);
        return {plain_.load_bits(f, element, word), stage_ready_};
    }
    Rgb<D> load_rgb(const Field& f, int element = 0) {
        return {load(f, element, 0), load(f, element, 1), load(f, element, 2)};
    }

    Wire<std::uint32_t> constant(int pixel_words) const { return plain_.constant(pixel_words); }

    // `after`: the condition that the second stage waits for.
    void next_fetch_stage(Wire<bool> after) {
        stage_ready_ = Ledger::active().charge(Unit::kFetchStage, std::max(stage_ready_, after.ready));
        loaded_ = false;
    }
    Wire<float> as_stored(const Field& f, Wire<float> value) {
        return {PlainPixel::as_stored(f, value.value), conversion(f, value.ready)};
    }

    void write(const Field& f, int element = 0) { plain_.write(f, element); }
    void write_if(Wire<bool> condition, const Field& f, int element) {
        plain_.write_if(condition.value || worst_, f, element);
    }
    void put(const Field& f, int element, int channel, Wire<float> value) {
        conversion(f, value.ready);
        plain_.put(f, element, channel, value.value);
    }
    void put_bits(const Field& f, int element, int word, Wire<std::uint32_t> value) {
        plain_.put_bits(f, element, word, value.value);
    }
    void put_rgb(const Field& f, int element, const Rgb<D>& rgb) {
        conversion(f, rgb.r.ready);
        conversion(f, rgb.g.ready);
        conversion(f, rgb.b.ready);
        plain_.put_rgb(f, element, {rgb.r.value, rgb.g.value, rgb.b.value});
    }
    void put_if(Wire<bool> condition, const Field& f, int element, int channel, Wire<float> value) {
        conversion(f, std::max(condition.ready, value.ready));
        plain_.put_if(condition.value, f, element, channel, value.value);
    }
    void put_rgb_if(Wire<bool> condition, const Field& f, int element, const Rgb<D>& rgb) {
        conversion(f, std::max(condition.ready, rgb.r.ready));
        conversion(f, std::max(condition.ready, rgb.g.ready));
        conversion(f, std::max(condition.ready, rgb.b.ready));
        plain_.put_rgb_if(condition.value, f, element, {rgb.r.value, rgb.g.value, rgb.b.value});
    }

    struct StoredRgb {
        PlainPixel::StoredRgb words{};
        int ready = 0;
    };
    StoredRgb converted(const Field& f, const Rgb<D>& rgb) {
        const int ready =
            std::max({conversion(f, rgb.r.ready), conversion(f, rgb.g.ready), conversion(f, rgb.b.ready)});
        return {PlainPixel::converted(f, {rgb.r.value, rgb.g.value, rgb.b.value}), ready};
    }
    void put_converted_if(Wire<bool> condition, const Field& f, int element, const StoredRgb& stored) {
        plain_.put_converted_if(condition.value, f, element, stored.words);
    }

    Wire<std::uint32_t> allocate_node() {
        return {plain_.allocate_node(), Ledger::active().charge(Unit::kIntegerAdder, 0)};
    }
    void write_node(const Field& f, Wire<std::uint32_t> index) { plain_.write_node(f, index.value); }
    ChargedPixel node(Wire<std::uint32_t> index) {
        ChargedPixel n(pool_->words(index.value), access_, pool_, worst_);
        n.whole_ = true;
        return n;
    }
    void fetch_node(Wire<std::uint32_t> index) { plain_.fetch_node(index.value); }

 private:
    void check_fetched(const Field& f, int element) {
        loaded_ = true;
        CHECK(whole_ || (((access_[f.surface].read | predicated_[f.surface]) >> element) & 1) != 0,
              "load of surface {} element {} that was not fetched", f.surface, element);
    }
    int conversion(const Field& f, int ready) {
        if (f.format == Format::kFloat32 || f.format == Format::kBits || f.format == Format::kUint32)
            return ready;
        return Ledger::active().charge(Unit::kConverter, ready);
    }

    PlainPixel plain_;
    PixelAccess& access_;
    NodePool* pool_;
    bool worst_;
    bool loaded_ = false;
    bool whole_ = false;
    int stage_ready_ = 0;  // when the bytes of the fetch stage are here
    std::array<std::uint64_t, kMaxTechniqueSurfaces> predicated_{};
};

}  // namespace ropsim
