#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "schemas/sensor_message.hpp"
#include "schemas/sequence_ranges.hpp"

namespace divemesh::sensor {

// One message of this device. Boot and sequence identify it.
struct Message {
    MessageKind kind = MessageKind::Status;
    std::string boot_id;
    std::int64_t sequence = 0;            // 0, 1, 2 ... of that boot
    std::int64_t uptime_ms = 0;           // since the boot, by the monotonic clock
    std::optional<std::int64_t> time_ms;  // unix, by the device's clock, which may be wrong
    std::string body;                     // the JSON object of its kind
    std::string jpeg;                     // of a preview
};

// Returns JSON as it is sent. Invalid UTF-8, as in names of dives, is replaced.
std::string text_of(const nlohmann::json& json);

// Convert a message, without its boot, to bytes for the disk and back. Throw Error{BadData} for
// invalid bytes.
std::string to_record(const Message& message);
Message message_of_record(std::string_view record, const std::string& boot_id);

// Returns a message as the stream carries it (docs/sensors.md): a preview as binary frame, others
// as text. `lost`: messages that the device no longer has; not with a preview.
std::string frame_of(const Message& message,
                     bool historical,
                     std::span<const SequenceRange> lost = {});
// Returns a frame that only reports lost messages.
std::string lost_frame(const std::string& boot_id, std::span<const SequenceRange> lost);

}  // namespace divemesh::sensor
