// Makes a trace from a deep OpenEXR file, our own or another program's.
#include "traces/interchange/deep_exr.h"
#include "traces/interchange/deep_exr_file.h"
#include "traces/interchange/deep_exr_foreign.h"
#include "traces/interchange/deep_exr_own.h"

#include <ImfTestFile.h>

namespace ropsim {

namespace {

const char* order_name(DeepOrder order) {
    switch (order) {
        case DeepOrder::kFile:
            return "file";
        case DeepOrder::kNearToFar:
            return "near_to_far";
        case DeepOrder::kFarToNear:
            return "far_to_near";
        case DeepOrder::kShuffle:
            return "shuffle";
    }
    return "";
}

}  // namespace

bool is_exr_file(const std::string& path) {
    return Imf::isOpenExrFile(path.c_str());
}

std::vector<std::string> import_deep_exr(const std::string& exr_path, const std::string& trace_path,
                                         const DeepImportOptions& options) {
    auto file = with_exr_faults(exr_path, [&] { return std::make_unique<DeepExrFile>(exr_path); });
    if (is_own_deep_exr(*file) && !options.order) {
        const OwnDeepExr own = with_exr_faults(exr_path, [&] { return read_own_deep_exr(*file); });
        TraceWriter writer(trace_path, own.header);
        writer.append(own.content);
        writer.finish();
        return {};
    }
    ForeignDeepImage image = with_exr_faults(exr_path, [&] { return read_foreign_deep_exr(*file); });
    const DeepOrder order = options.order.value_or(DeepOrder::kShuffle);
    image.header.scene += fmt::format(", order {}", order_name(order));
    if (order == DeepOrder::kShuffle) image.header.scene += fmt::format(" seed {}", options.seed);
    TraceWriter writer(trace_path, image.header);
    emit_in_rounds(image, order, options.seed,
                   [&](const std::vector<Fragment>& piece) { writer.append(piece); });
    writer.finish();
    return image.notes;
}

}  // namespace ropsim
