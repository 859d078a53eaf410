#include "rop/single_pixel.h"

#include "base/error.h"
#include "rop/double_reading/boxed_double.h"
#include "rop/operation_log.h"
#include "rop/pass_sequence.h"
#include "rop/registry.h"

#include <algorithm>
#include <numeric>
#include <type_traits>

namespace ropsim {
namespace {

// In the double-precision reading, which exchanges the one for the other.
constexpr bool kDoublePrecision = std::is_same_v<float, double>;
// Operations between looks at the table of doubles, and the number of entries at which it is made anew.
constexpr std::size_t kBatch = 2048;
constexpr std::size_t kManyDoubles = std::size_t{1} << 20;
// Enough for any technique that takes a few nodes a fragment.
constexpr std::uint64_t kPoolNodes = std::uint64_t{1} << 22;

int geometry_passes(const Declaration& declared) {
    int passes = 0;
    for (int p = 0; p < static_cast<int>(declared.passes.size()); ++p) {
        if (declared.passes[static_cast<std::size_t>(p)].kind != PassKind::kGeometry) continue;
        const bool repeated = declared.repeat.first <= p && p <= declared.repeat.last;
        passes += repeated ? declared.repeat.rounds : 1;
    }
    return passes;
}

class Pixel : public SinglePixel {
 public:
    Pixel(const std::string& text, const TraceHeader& header, std::uint64_t seed) : header_(header) {
        header_.width = header_.height = 1;
        header_.samples = 1;
        header_.opaque = OpaqueLayer{{0, 0, 0}, {0}};
        header_.materials = header_.depth_slopes = false;
        TechniqueSpec spec = parse_technique(text, "--technique");
        operation_ = make_operation(spec, screen_of(header_, seed));
        const Declaration& declared = operation_->declaration();
        technique_ = {declared.ordering == Ordering::kAny,
                      declared.random,
                      operation_->has_visibility(),
                      declared.image_is_color,
                      declared.storage_bits_per_pixel(),
                      declared.storage_bits_per_node(),
                      geometry_passes(declared)};
        make_store();
    }
    const PixelTechnique& technique() const override { return technique_; }

    std::array<double, 3> run(const PixelScene& scene) override {
        start(scene);
        const Declaration& declared = operation_->declaration();
        OperationLog log(declared, false);
        const StoreMap stores(1, 1, {store_.get()});
        PassSequence sequence(declared);
        while (!sequence.done()) {
            const Pass& pass = sequence.current();
            if (sequence.round() > 0) store_->restore(pass.restores);
            if (pass.kind == PassKind::kImage)
                operation_->image_pass(sequence.pass(), sequence.round(), *store_, stores, 0, 0, log);
            else
                run_pass(sequence, scene, log);
            const int watched = sequence.watched_path();
            sequence.advance(watched < 0 ? 0 : log.path_count(static_cast<std::size_t>(watched)));
        }
        std::array<float, std::size_t{3} * kTilePixels> rgb{};
        operation_->resolve(*store_, stores, 0, 0, rgb.data(), log);
        for (std::size_t p = 0; p < paths_.size(); ++p) paths_[p] = log.path_count(p);
        return {rgb[0], rgb[1], rgb[2]};
    }

    void visibility(std::span<const glm::vec3::value_type> depths, std::span<double> values) override {
        const std::vector<float> asked(depths.begin(), depths.end());
        std::vector<float> answers(values.size());
        operation_->visibility(*store_, 0, 0, asked, answers);
        std::copy(answers.begin(), answers.end(), values.begin());
    }
    const std::vector<std::uint64_t>& paths() const override { return paths_; }

 private:
    void make_store() {
        const Declaration& declared = operation_->declaration();
        const auto pooled = [](const Surface& s) { return s.layout == Layout::kPool; };
        has_pool_ = std::ranges::any_of(declared.surfaces, pooled);
        store_ = std::make_unique<PixelStore>(declared, header_, has_pool_ ? kPoolNodes : 0,
                                              operation_->pixel_constant());
        paths_.assign(declared.paths.size(), 0);
    }
    void start(const PixelScene& scene) {
        if constexpr (kDoublePrecision) forget_boxed_doubles();
        header_.background = scene.background;
        header_.opaque->rgb = {scene.background.r, scene.background.g, scene.background.b};
        header_.opaque->depth = {scene.opaque_depth};
        if (has_pool_) make_store();  // its nodes are not returned
        std::uint32_t* const words = store_->pixel(0, 0);
        store_->initial_pixel(0, 0, initial_);
        std::ranges::copy(initial_, words);
        const bool all = !operation_->declaration().zero_alpha_harmless;
        operated_.clear();
        for (std::uint32_t i = 0; i < scene.fragments.size(); ++i) {
            const Fragment& f = scene.fragments[i];
            if (all || f.a != 0 || f.r != 0 || f.g != 0 || f.b != 0) operated_.push_back(i);
        }
    }
    void run_pass(const PassSequence& sequence, const PixelScene& scene, OperationLog& log) {
        const std::span<const std::uint32_t> all = operated_;
        const std::size_t batch = kDoublePrecision ? kBatch : std::max(all.size(), std::size_t{1});
        for (std::size_t first = 0; first < all.size(); first += batch) {
            operation_->run(sequence.pass(), sequence.round(), {scene.fragments},
                            all.subspan(first, std::min(batch, all.size() - first)), *store_, log);
            if (kDoublePrecision && boxed_doubles() > kManyDoubles) renew_doubles();
        }
    }
    // The table grows with every store: keeps what the pixel and its nodes still hold.
    void renew_doubles() {
        std::vector<std::uint32_t*> words;
        for (const Surface& s : operation_->declaration().surfaces) {
            const bool pooled = s.layout == Layout::kPool;
            const std::uint64_t nodes = pooled ? store_->pool()->used() : 1;
            for (std::uint64_t n = 0; n < nodes; ++n) {
                std::uint32_t* const state =
                    pooled ? store_->pool()->words(static_cast<std::uint32_t>(n)) : store_->pixel(0, 0);
                for (std::size_t w = 0; w < s.word_formats.size(); ++w)
                    if (s.word_formats[w] != Format::kBits && s.word_formats[w] != Format::kUint32)
                        words.push_back(state + s.first_word + w);
            }
        }
        std::vector<double> values(words.size());
        std::ranges::transform(words, values.begin(),
                               [](const std::uint32_t* w) { return unboxed_double(*w); });
        forget_boxed_doubles();
        for (std::size_t i = 0; i < words.size(); ++i) *words[i] = boxed_double(values[i]);
    }

    TraceHeader header_;
    std::unique_ptr<FramebufferOperation> operation_;
    PixelTechnique technique_;
    std::unique_ptr<PixelStore> store_;
    bool has_pool_ = false;
    std::vector<std::uint32_t> initial_;
    std::vector<std::uint32_t> operated_;
    std::vector<std::uint64_t> paths_;
};

}  // namespace

std::unique_ptr<SinglePixel> make_single_pixel(const std::string& technique, const TraceHeader& header,
                                               std::uint64_t seed) {
    return std::make_unique<Pixel>(technique, header, seed);
}

}  // namespace ropsim
