#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/sequence_ranges.hpp"

namespace divemesh {

// What a device says; the word is the key of its body.
//
//   hello    who it is and what it can be asked to do; the newest one counts
//   status   how it is now, or was (`historical`)
//   preview  what a camera sees
//   outcome  what became of a command
enum class MessageKind { Hello, Status, Preview, Outcome };
std::string_view to_string(MessageKind kind);

// One message of a device. Its boot and its sequence name it: a second one with the same name is
// the same message, sent again.
struct SensorMessage {
    MessageKind kind = MessageKind::Status;
    std::int64_t sequence = 0;            // 0, 1, 2 ... of this boot
    std::int64_t uptime_ms = 0;           // its clock that nobody sets, since the boot
    std::optional<std::int64_t> time_ms;  // unix, by its clock that may be wrong
    bool historical = false;              // from its memory: how it was, not how it is
    nlohmann::json body;                  // the object of its kind
    std::string jpeg;                     // of a preview
};

// What one request of a device brings: messages of one boot, and what of it is lost for good.
struct SensorReport {
    std::string boot_id;
    std::vector<SensorMessage> messages;
    std::vector<SequenceRange> lost;
};

inline constexpr std::size_t kMaxMessages = 1000;  // of one report
inline constexpr std::size_t kMaxLost = 64;
inline constexpr std::size_t kMaxSensorMessageBytes = 16 << 10;

inline constexpr std::size_t kMaxJpegBytes = 256 << 10;
inline constexpr int kMaxImageSide = 8192;
inline constexpr std::size_t kMaxFrameBytes = 4 + kMaxSensorMessageBytes + kMaxJpegBytes;

// Reads {"boot_id": ..., "messages": [...], "lost": [[first, last], ...]}; the JPEG of a preview is
// base64 there. Throws InvalidInput that names every fault.
SensorReport sensor_report(const nlohmann::json& body);

// A preview as one run of bytes: the length of its header (4 bytes, big endian), the header in
// JSON, the JPEG. Throws Error{InvalidArgument} for what is too short to be one.
struct PreviewFrame {
    std::string_view header;
    std::string_view jpeg;
};
PreviewFrame split_preview(std::string_view frame);

// The report of one preview, of its header {"boot_id": ..., "seq": ..., "preview": {...}}. Throws
// as sensor_report() does.
SensorReport sensor_preview(nlohmann::json header, std::string_view jpeg);

}  // namespace divemesh
