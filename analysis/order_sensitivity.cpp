// One order at a time on disk, every technique over it.
#include "analysis/order_sensitivity.h"

#include "analysis/progress.h"
#include "analysis/standard_techniques.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "model/run.h"
#include "rop/reference.h"
#include "traces/trace_order.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <set>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct ArrivalOrderOf {
    std::string name;
    std::optional<ArrivalOrder> order;  // absent: as captured
    std::uint64_t seed = 0;
};

std::vector<ArrivalOrderOf> orders_of(const OrderSensitivityOptions& options) {
    std::vector<ArrivalOrderOf> orders{{kNamedOrders[0], std::nullopt, 0},
                                       {kNamedOrders[1], ArrivalOrder::kNearToFar, 0},
                                       {kNamedOrders[2], ArrivalOrder::kFarToNear, 0}};
    for (int i = 0; i < options.orders; ++i) {
        const std::uint64_t seed = options.order_seed + static_cast<std::uint64_t>(i);
        orders.push_back({fmt::format("order {}", seed), ArrivalOrder::kShuffle, seed});
    }
    return orders;
}

// What the technique declares, or why it cannot run.
OrderSensitivityOfTechnique declared(const std::string& text, const TraceHeader& header) {
    OrderSensitivityOfTechnique technique;
    technique.technique = text;
    technique.failure = refusal(text, header);
    if (!technique.failure.empty()) return technique;
    TechniqueSpec spec = parse_technique(text, "--technique");
    const auto operation = make_operation(spec, screen_of(header, 0));
    technique.any_order = operation->declaration().ordering == Ordering::kAny;
    technique.random = operation->declaration().random;
    for (const auto& [key, resolved] : spec.parameters.resolved()) technique.parameters[key] = resolved.value;
    return technique;
}

// The study before its runs. A technique that the user named must be able to run.
OrderSensitivity prepared(const OrderSensitivityOptions& options, const TraceReader& trace) {
    const TraceHeader& header = trace.header();
    OrderSensitivity study{options,
                           trace.hash(),
                           header.scene,
                           header.width,
                           header.height,
                           header.samples,
                           trace.fragment_count(),
                           0,
                           {}};
    std::set<std::string> seen;
    const bool named = !options.techniques.empty();
    for (const std::string& text : named ? options.techniques : techniques_at_defaults()) {
        if (!seen.insert(text).second)
            throw UserError("--technique", fmt::format("'{}' is given twice; leave one out", text));
        study.techniques.push_back(declared(text, header));
        const std::string& failure = study.techniques.back().failure;
        if (named && !failure.empty()) throw UserError("--technique", failure);
    }
    return study;
}

std::vector<std::uint32_t> covered_pixels(const Image& reference) {
    std::vector<std::uint32_t> pixels;
    const auto layers = static_cast<std::size_t>(reference.channel("layers"));
    const std::size_t count =
        static_cast<std::size_t>(reference.width) * static_cast<std::size_t>(reference.height);
    for (std::size_t i = 0; i < count; ++i)
        if (reference.values[i * reference.channels.size() + layers] > 0)
            pixels.push_back(static_cast<std::uint32_t>(i));
    return pixels;
}

class Study {
 public:
    explicit Study(const OrderSensitivityOptions& options)
        : trace_(options.trace), study_(prepared(options, trace_)) {}

    OrderSensitivity run() {
        covered_ = covered_pixels(reference(DisplayFilter::kBox));
        study_.covered_pixels = covered_.size();
        for (const OrderSensitivityOfTechnique& technique : study_.techniques)
            spreads_.emplace_back(technique.failure.empty() ? covered_ : std::vector<std::uint32_t>());
        const std::vector<ArrivalOrderOf> orders = orders_of(study_.options);
        start_progress(orders.size());
        for (std::size_t i = 0; i < orders.size(); ++i) run_order(orders[i], i);
        for (std::size_t t = 0; t < spreads_.size(); ++t)
            if (study_.techniques[t].failure.empty()) study_.techniques[t].spread = spreads_[t].figures();
        return std::move(study_);
    }

 private:
    const Image& reference(DisplayFilter filter) {
        std::optional<Image>& image = filter == DisplayFilter::kGaussian ? gaussian_ : box_;
        if (!image) image = cached_reference_image(trace_, study_.options.threads, filter);
        return *image;
    }

    // What is refused is told once, not for every order.
    void start_progress(std::size_t orders) {
        std::size_t steps = 0;
        for (const OrderSensitivityOfTechnique& technique : study_.techniques)
            steps += technique.failure.empty() ? orders : 1;
        progress_ = std::make_unique<Progress>(steps);
        for (const OrderSensitivityOfTechnique& technique : study_.techniques)
            if (!technique.failure.empty()) progress_->finished(technique.technique, technique.failure);
    }

    void run_order(const ArrivalOrderOf& order, std::size_t number) {
        // Never committed: goes away with this call, or with the process.
        std::optional<AtomicFile> reordered;
        std::string file = study_.options.trace;
        if (order.order) {
            reordered.emplace((std::filesystem::path(study_.options.directory) / "reordered.trace").string());
            file = reordered->temporary_path();
            order_trace(study_.options.trace, file, *order.order, order.seed);
        }
        for (std::size_t t = 0; t < study_.techniques.size(); ++t) {
            OrderSensitivityOfTechnique& technique = study_.techniques[t];
            if (!technique.failure.empty()) continue;
            run_technique(technique, spreads_[t], file, number);
            progress_->finished(fmt::format("{} {}", order.name, technique.technique), "");
        }
    }

    void run_technique(OrderSensitivityOfTechnique& technique, ImageSpread& spread, const std::string& file,
                       std::size_t number) {
        RunOptions run;
        run.trace = file;
        run.technique = technique.technique;
        run.hardware = study_.options.hardware;
        run.settings = study_.options.settings;
        run.fidelity = Fidelity::kCount;
        run.seed = study_.options.seed;
        run.threads = study_.options.threads;
        run.error = false;  // the reference is the captured trace's
        const RunResult result = run_simulation(run);
        const double error = rmse8_over(result.image, reference(result.declaration.display_filter), covered_);
        if (number < kNamedOrders.size()) {
            technique.named_rmse8_covered[number] = error;
            return;
        }
        technique.random_rmse8_covered.push_back(error);
        spread.add(result.image);
    }

    TraceReader trace_;
    OrderSensitivity study_;
    std::optional<Image> box_, gaussian_;
    std::vector<std::uint32_t> covered_;
    std::vector<ImageSpread> spreads_;
    std::unique_ptr<Progress> progress_;
};

}  // namespace

void check_order_sensitivity(const OrderSensitivityOptions& options) {
    prepared(options, TraceReader(options.trace));
}

OrderSensitivity run_order_sensitivity(const OrderSensitivityOptions& options) {
    CHECK(options.orders >= 2, "{} orders", options.orders);
    return Study(options).run();
}

}  // namespace ropsim
