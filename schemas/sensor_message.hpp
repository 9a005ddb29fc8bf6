#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/sequence_ranges.hpp"

namespace divemesh {

// The kinds of messages of a device; the word is the key of its body.
//
//   hello    its identity and the commands it supports; the newest one counts
//   status   its condition now, or in the past (`historical`)
//   preview  an image of a camera
//   outcome  the outcome of a command
enum class MessageKind { Hello, Status, Preview, Outcome };
std::string_view to_string(MessageKind kind);

// One message of a device. Its boot and sequence identify it: a second one with both equal is the
// same message, sent again.
struct SensorMessage {
    MessageKind kind = MessageKind::Status;
    std::int64_t sequence = 0;            // 0, 1, 2 ... of this boot
    std::int64_t uptime_ms = 0;           // by its monotonic clock, since the boot
    std::optional<std::int64_t> time_ms;  // unix, by its wall clock, which may be wrong
    bool historical = false;              // stored: describes the past, not the present
    nlohmann::json body;                  // the object of its kind
    std::string jpeg;                     // of a preview
};

// One request of a device: messages of one boot, and which of its messages are lost for good.
struct SensorReport {
    std::string boot_id;
    std::vector<SensorMessage> messages;
    std::vector<SequenceRange> lost;
};

inline constexpr std::size_t kMaxMessages = 1000;  // per report
inline constexpr std::size_t kMaxLost = 64;
inline constexpr std::size_t kMaxSensorMessageBytes = 16 << 10;

inline constexpr std::size_t kMaxJpegBytes = 256 << 10;
inline constexpr int kMaxImageSide = 8192;
inline constexpr std::size_t kMaxFrameBytes = 4 + kMaxSensorMessageBytes + kMaxJpegBytes;

// Parses {"boot_id": ..., "messages": [...], "lost": [[first, last], ...]}, where the JPEG of a
// preview is base64. Throws InvalidInput, which names every fault.
SensorReport sensor_report(const nlohmann::json& body);

// The parts of a preview that is sent as one block of bytes: the length of its header (4 bytes,
// big-endian), the header in JSON, the JPEG.
struct PreviewFrame {
    std::string_view header;
    std::string_view jpeg;
};
// Splits a block of bytes into views of it. Throws Error{InvalidArgument} if it is too short.
PreviewFrame split_preview(std::string_view frame);

// Returns the report of one preview from its header {"boot_id": ..., "seq": ..., "preview": {...}}.
// Throws as sensor_report() does.
SensorReport sensor_preview(nlohmann::json header, std::string_view jpeg);

}  // namespace divemesh
