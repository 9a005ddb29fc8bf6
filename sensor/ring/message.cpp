#include "sensor/ring/message.hpp"

#include <cstring>
#include <nlohmann/json.hpp>

#include "schemas/error.hpp"

namespace divemesh::sensor {
namespace {

using nlohmann::json;

constexpr std::uint32_t kNumKinds = 4;
constexpr std::int64_t kNoTime = -1;

// The head of a record. Native byte order, because the same machine reads and writes it.
struct RecordHead {
    std::int64_t sequence = 0;
    std::int64_t uptime_ms = 0;
    std::int64_t time_ms = kNoTime;
    std::uint32_t kind = 0;
    std::uint32_t num_body_bytes = 0;
};

json head_of(const Message& message, bool historical) {
    json head = {{"seq", message.sequence}, {"uptime_ms", message.uptime_ms}};
    if (message.time_ms) head["time_ms"] = *message.time_ms;
    if (historical) head["historical"] = true;
    head[std::string(to_string(message.kind))] = json::parse(message.body);
    return head;
}

json pairs_of(std::span<const SequenceRange> ranges) {
    json pairs = json::array();
    for (const SequenceRange& range : ranges) pairs.push_back({range.first, range.last});
    return pairs;
}

std::string preview_frame(const Message& message, bool historical) {
    json head = head_of(message, historical);
    head["boot_id"] = message.boot_id;
    const std::string text = text_of(head);
    std::string frame;
    for (int shift = 24; shift >= 0; shift -= 8)
        frame.push_back(static_cast<char>((text.size() >> shift) & 0xFF));
    return frame.append(text).append(message.jpeg);
}

}  // namespace

std::string text_of(const json& frame) {
    return frame.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string to_record(const Message& message) {
    const RecordHead head{message.sequence,
                          message.uptime_ms,
                          message.time_ms.value_or(kNoTime),
                          static_cast<std::uint32_t>(message.kind),
                          static_cast<std::uint32_t>(message.body.size())};
    std::string record(sizeof head, '\0');
    std::memcpy(record.data(), &head, sizeof head);
    return record.append(message.body).append(message.jpeg);
}

Message message_of_record(std::string_view record, const std::string& boot_id) {
    RecordHead head;
    if (record.size() >= sizeof head) std::memcpy(&head, record.data(), sizeof head);
    if (record.size() < sizeof head || head.kind >= kNumKinds ||
        head.num_body_bytes > record.size() - sizeof head)
        throw Error(ErrorCode::BadData, "a record of the ring is not a message");
    Message message;
    message.kind = static_cast<MessageKind>(head.kind);
    message.boot_id = boot_id;
    message.sequence = head.sequence;
    message.uptime_ms = head.uptime_ms;
    if (head.time_ms != kNoTime) message.time_ms = head.time_ms;
    record.remove_prefix(sizeof head);
    message.body = record.substr(0, head.num_body_bytes);
    message.jpeg = record.substr(head.num_body_bytes);
    return message;
}

std::string frame_of(const Message& message, bool historical, std::span<const SequenceRange> lost) {
    if (message.kind == MessageKind::Preview) return preview_frame(message, historical);
    json report = {{"boot_id", message.boot_id},
                   {"messages", json::array({head_of(message, historical)})}};
    if (!lost.empty()) report["lost"] = pairs_of(lost);
    return text_of(report);
}

std::string lost_frame(const std::string& boot_id, std::span<const SequenceRange> lost) {
    return text_of({{"boot_id", boot_id}, {"messages", json::array()}, {"lost", pairs_of(lost)}});
}

}  // namespace divemesh::sensor
