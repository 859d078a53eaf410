// Reads back the deep OpenEXR files that this program wrote, bit for bit.
#include "traces/interchange/deep_exr_own.h"

#include "traces/content_hash.h"
#include "traces/interchange/deep_exr_records.h"
#include "traces/trace_header.h"
#include "traces/value_ranges.h"

#include <ImfChannelList.h>
#include <ImfInputPart.h>
#include <ImfStringAttribute.h>

namespace ropsim {

namespace {

constexpr std::uint64_t kLargestDeflateRatio = 1032;

const std::string* text_attribute(const DeepExrFile& file, const char* name) {
    const auto* attribute = file.header().findTypedAttribute<Imf::StringAttribute>(name);
    return attribute != nullptr ? &attribute->value() : nullptr;
}

TraceHeader stored_header(const DeepExrFile& file) {
    TraceHeader header;
    try {
        header = parse_header(*text_attribute(file, kDeepHeaderAttribute)).header;
    } catch (const FormatFault& fault) {
        file.fail(fmt::format("attribute {}: {}", kDeepHeaderAttribute, fault.what()));
    }
    if (file.left() != 0 || file.top() != 0 || file.width() != header.width || file.height() != header.height)
        file.fail(fmt::format("its data window does not match the {}x{} pixels of attribute {}", header.width,
                              header.height, kDeepHeaderAttribute));
    return header;
}

void check_channels(const Imf::ChannelList& channels, const std::vector<DeepChannel>& wanted,
                    const DeepExrFile& file) {
    for (const DeepChannel& channel : wanted) {
        const Imf::Channel* found = channels.findChannel(channel.name);
        if (found == nullptr || found->type != channel.type)
            file.fail(
                fmt::format("channel '{}' is missing or of another type than ropsim writes", channel.name));
    }
}

OpaqueLayer read_opaque(DeepExrFile& file, const TraceHeader& header, int number, std::uint64_t file_bytes) {
    const auto samples = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height) *
                         static_cast<std::size_t>(header.samples);
    if (samples * 4 * sizeof(float) / kLargestDeflateRatio > file_bytes)
        file.fail("is too small for the opaque layer it claims; it is damaged");
    Imf::InputPart part(file.parts(), number);
    const Imath::Box2i window = part.header().dataWindow();
    if (window.min != Imath::V2i(0, 0) || window.max != Imath::V2i(header.width - 1, header.height - 1))
        file.fail("the part 'opaque' is of another size");
    OpaqueLayer layer;
    layer.rgb.resize(3 * samples);
    layer.depth.resize(samples);
    std::vector<DeepChannel> wanted;
    for (const std::string& name : opaque_channels(header.samples)) wanted.push_back({name, Imf::FLOAT, 0});
    check_channels(part.header().channels(), wanted, file);
    part.setFrameBuffer(opaque_frame(header, layer));
    part.readPixels(0, header.height - 1);
    return layer;
}

// Puts one row's samples at their places.
class Placer {
 public:
    Placer(const DeepExrFile& file, OwnDeepExr& out) : file_(file), out_(out) {
        const std::uint64_t count = file.samples();
        if (count > std::uint64_t{1} << 32) file.fail("holds more than 2^32 fragments");
        seen_.resize(count);
        out.content.fragments.resize(count);
        if (out.header.depth_slopes) out.content.slopes.resize(count);
        if (out.header.materials) out.content.materials.resize(count);
    }

    void place(const DeepRecord& record, int x, int y) {
        const TraceHeader& header = out_.header;
        const auto fail = [&](const std::string& what) {
            file_.fail(fmt::format("pixel ({}, {}): {}; the file is damaged or was edited", x, y, what));
        };
        if (record.order >= seen_.size() || seen_[record.order])
            fail(fmt::format("arrival number {} is {}", record.order,
                             record.order >= seen_.size() ? "beyond the last fragment" : "there twice"));
        seen_[record.order] = true;
        if (record.draw >= header.draws.size() || record.coverage >= 1u << header.samples)
            fail(fmt::format("draw {} or coverage {} does not exist", record.draw, record.coverage));
        const std::size_t i = record.order;
        from_record(header, record, x, y, out_.content, i);
        const bool good = in_range(out_.content.fragments[i]) &&
                          (!header.depth_slopes || in_range(out_.content.slopes[i])) &&
                          (!header.materials || in_range(out_.content.materials[i]));
        if (!good && !header.non_finite) fail("a value is out of range");
    }

 private:
    const DeepExrFile& file_;
    OwnDeepExr& out_;
    std::vector<bool> seen_;
};

std::string content_hash(const OwnDeepExr& own) {
    ContentHash hash(own.header);
    hash.add(own.content);
    return hash_text(own.header, hash.fragments(), hash.slopes(), hash.materials());
}

}  // namespace

bool is_own_deep_exr(const DeepExrFile& file) {
    return text_attribute(file, kDeepHeaderAttribute) != nullptr;
}

OwnDeepExr read_own_deep_exr(DeepExrFile& file) {
    OwnDeepExr own;
    own.header = stored_header(file);
    const std::vector<DeepChannel> channels = fragment_channels(own.header);
    check_channels(file.header().channels(), channels, file);
    Placer placer(file, own);
    DeepRow<DeepRecord> row(0, file.width(), channels);
    file.attach(row);
    for (int y = 0; y < file.height(); ++y) {
        file.read_row(y, row);
        const DeepRecord* next = row.records().data();
        for (int x = 0; x < file.width(); ++x)
            for (std::uint32_t k = 0; k < row.counts()[static_cast<std::size_t>(x)]; ++k)
                placer.place(*next++, x, y);
    }
    if (const std::optional<int> opaque = file.part(kOpaquePart))
        own.header.opaque = read_opaque(file, own.header, *opaque, file.bytes());
    const std::string* hash = text_attribute(file, kDeepHashAttribute);
    if (hash == nullptr || *hash != content_hash(own))
        file.fail(fmt::format(
            "its content does not match its attribute {}: it is damaged or was edited; to take it "
            "as any deep image, name an arrival order with --order",
            kDeepHashAttribute));
    return own;
}

}  // namespace ropsim
