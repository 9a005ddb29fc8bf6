#include "worker/recording/ros1_container.hpp"

#include <algorithm>
#include <utility>

#include "schemas/error.hpp"
#include "worker/recording/byte_cursor.hpp"
#include "worker/recording/unpack.hpp"

namespace divemesh::recording {
namespace {

// The records that matter here, by the field `op` of their headers.
constexpr std::uint8_t kMessage = 0x02;
constexpr std::uint8_t kBagHeader = 0x03;
constexpr std::uint8_t kChunk = 0x05;
constexpr std::uint8_t kConnection = 0x07;

// Far above any header that rosbag writes: some fields of a few bytes each.
constexpr std::uint32_t kMaxHeader_bytes = 1U << 20U;
constexpr std::int64_t kNsPerS = 1'000'000'000;
// A publisher has a connection to each of its topics.
constexpr std::size_t kMaxConnections = 100'000;

// Returns the value of a field ("name=value") of a header; nullopt if it has none of this name.
std::optional<std::string_view> field(std::string_view header, std::string_view name) {
    ByteCursor cursor(header);
    while (const auto entry = cursor.take_sized<std::uint32_t>()) {
        const std::size_t equals = entry->find('=');
        if (equals != std::string_view::npos && entry->substr(0, equals) == name)
            return entry->substr(equals + 1);
    }
    return std::nullopt;
}

// Returns the number in a field; nullopt if it is missing or of another size.
template <typename Value>
std::optional<Value> number_in(std::string_view header, std::string_view name) {
    const auto value = field(header, name);
    if (!value || value->size() != sizeof(Value)) return std::nullopt;
    return ByteCursor(*value).take<Value>();
}

// Returns a time of seconds and nanoseconds.
std::optional<std::int64_t> time_in(std::string_view header) {
    const auto value = field(header, "time");
    if (!value || value->size() != 2 * sizeof(std::uint32_t)) return std::nullopt;
    ByteCursor cursor(*value);
    const std::int64_t seconds = *cursor.take<std::uint32_t>();
    return seconds * kNsPerS + *cursor.take<std::uint32_t>();
}

struct BagRecord {
    std::string_view header;
    std::string_view data;
    std::uint8_t op() const { return number_in<std::uint8_t>(header, "op").value_or(0); }
};

// Takes the next record; nullopt at the end, and where the bytes end within it.
std::optional<BagRecord> take_bag_record(ByteCursor& cursor) {
    const auto header = cursor.take_sized<std::uint32_t>();
    const auto data = header ? cursor.take_sized<std::uint32_t>() : std::nullopt;
    if (!data) return std::nullopt;
    return BagRecord{*header, *data};
}

// A record of the file by its header alone.
struct RecordHead {
    std::string header;
    std::int64_t data_offset_bytes = 0;
    std::int64_t data_bytes = 0;
};

// Reads the header of the record at a place; nullopt if the file ends in it, or it is absurd.
std::optional<RecordHead> read_head(const InputFile& file, std::int64_t offset_bytes) {
    constexpr std::int64_t kSize_bytes = sizeof(std::uint32_t);
    const std::string size = file.read(offset_bytes, kSize_bytes);
    const auto header_bytes = ByteCursor(size).take<std::uint32_t>();
    if (!header_bytes || *header_bytes > kMaxHeader_bytes) return std::nullopt;
    RecordHead head;
    head.header = file.read(offset_bytes + kSize_bytes, *header_bytes + kSize_bytes);
    ByteCursor cursor(head.header);
    const bool has_header = cursor.take_bytes(*header_bytes).has_value();
    const auto data_bytes = cursor.take<std::uint32_t>();
    if (!has_header || !data_bytes) return std::nullopt;
    head.header.resize(*header_bytes);
    head.data_offset_bytes = offset_bytes + 2 * kSize_bytes + *header_bytes;
    head.data_bytes = *data_bytes;
    return head;
}

}  // namespace

Ros1Container::Ros1Container(InputFile file,
                             dive::FindingLog& findings,
                             const base::ProgressCallback& progress)
    : ChunkedContainer(std::move(file)) {
    scan(findings, progress);
}

void Ros1Container::scan(dive::FindingLog& findings, const base::ProgressCallback& progress) {
    const std::int64_t size = file_.size_bytes();
    for (std::int64_t at = std::ssize(kRos1Magic); at < size;) {
        progress({"import", 0.5 * static_cast<double>(at) / static_cast<double>(size)});
        const auto head = read_head(file_, at);
        if (!head) return report_cut(at, findings);
        const std::uint8_t op = number_in<std::uint8_t>(head->header, "op").value_or(0);
        const std::string_view encryptor = field(head->header, "encryptor").value_or("");
        if (op == kBagHeader && !encryptor.empty())
            throw Error(ErrorCode::BadData,
                        file_.path().string() + " is encrypted: decrypt it with rosbag decrypt");
        const std::int64_t end = head->data_offset_bytes + head->data_bytes;
        if (op == kChunk || op == kMessage || op == kConnection)
            add({0, at, std::min(end, size)}, findings);
        if (end > size) return report_cut(at, findings);
        at = end;
    }
}

// Opens a chunk from its whole record, which the file may cut: then the records before the cut
// are given. Other records are given as they are.
OpenedBlock Ros1Container::open(std::string bytes) const {
    ByteCursor cursor(bytes);
    const auto header = cursor.take_sized<std::uint32_t>();
    const auto data_bytes = cursor.take<std::uint32_t>();
    if (!header || !data_bytes) return {"", "the head of a record is damaged"};
    if (number_in<std::uint8_t>(*header, "op") != kChunk) return {std::move(bytes), ""};
    const auto name = field(*header, "compression");
    const auto size = number_in<std::uint32_t>(*header, "size");
    const auto codec = name ? codec_from_text(*name) : std::nullopt;
    if (!size) return {"", "the head of a chunk is damaged"};
    if (!codec || *codec == Codec::Zstd)
        return {"", "a chunk is compressed in a way that is not known"};
    if (*size > kMaxBlock_bytes)
        return {"", "a chunk states " + std::to_string(*size) + " bytes, which is absurd"};
    Unpacked unpacked = unpack(*codec, cursor.rest().substr(0, *data_bytes), *size);
    if (!unpacked.is_whole && *data_bytes <= cursor.rest().size())
        return {"", "a chunk does not decompress to the size that it states"};
    return {std::move(unpacked.bytes), ""};
}

void Ros1Container::learn(std::string_view records) {
    ByteCursor cursor(records);
    while (const auto record = take_bag_record(cursor))
        if (record->op() == kConnection) learn_connection(record->header, record->data);
}

void Ros1Container::learn_connection(std::string_view header, std::string_view data) {
    const auto number = number_in<std::uint32_t>(header, "conn");
    const auto name = field(header, "topic");
    const auto type = field(data, "type");
    if (!number || !name || !type || connections_.contains(*number)) return;
    if (connections_.size() == kMaxConnections) return;
    const auto topic = topic_of(*name, *type, Serialization::Ros1);
    if (topic) connections_.emplace(*number, *topic);
}

BlockContents Ros1Container::parse(std::string bytes) const {
    BlockContents contents;
    ByteCursor cursor(bytes);
    while (const auto record = take_bag_record(cursor)) {
        if (record->op() != kMessage) continue;
        const auto connection = number_in<std::uint32_t>(record->header, "conn");
        const auto log_time_ns = time_in(record->header);
        if (!connection || !log_time_ns) continue;
        const auto topic = connections_.find(*connection);
        if (topic == connections_.end()) continue;
        contents.messages.push_back({topic->second,
                                     *log_time_ns,
                                     static_cast<std::size_t>(record->data.data() - bytes.data()),
                                     record->data.size()});
    }
    contents.bytes = std::move(bytes);
    return contents;
}

}  // namespace divemesh::recording
