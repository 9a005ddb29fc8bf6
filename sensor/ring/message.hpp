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

// One thing that this device says, or said. Boot and sequence name it.
struct Message {
    MessageKind kind = MessageKind::Status;
    std::string boot_id;
    std::int64_t sequence = 0;            // 0, 1, 2 ... of that boot
    std::int64_t uptime_ms = 0;           // since the boot, by a clock that nobody sets
    std::optional<std::int64_t> time_ms;  // unix, by the device's clock that may be wrong
    std::string body;                     // the JSON object of its kind
    std::string jpeg;                     // of a preview
};

// JSON as it is sent; bytes that are not UTF-8 are replaced, as names of dives may have them.
std::string text_of(const nlohmann::json& json);

// A message as bytes for the disk, all but its boot, and back. Throws Error{BadData} for bytes that
// are no message.
std::string to_record(const Message& message);
Message message_of_record(std::string_view record, const std::string& boot_id);

// A message as the stream carries it (docs/sensors.md): a preview as binary frame, all others as
// text. `lost`: what the device has no more; not with a preview.
std::string frame_of(const Message& message,
                     bool historical,
                     std::span<const SequenceRange> lost = {});
// Nothing but what is lost.
std::string lost_frame(const std::string& boot_id, std::span<const SequenceRange> lost);

}  // namespace divemesh::sensor
