#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/sequence_ranges.hpp"

namespace divemesh {

// What a device says when it comes: who it is, what it can be asked to do. Its newest one counts.
// Status: how it is now, or was (`historical`).
enum class MessageKind { Hello, Status };

// One message of a device. Its boot and its sequence name it: a second one with the same name is
// the same message, sent again.
struct SensorMessage {
    MessageKind kind = MessageKind::Status;
    std::int64_t sequence = 0;            // 0, 1, 2 ... of this boot
    std::int64_t uptime_ms = 0;           // its clock that nobody sets, since the boot
    std::optional<std::int64_t> time_ms;  // unix, by its clock that may be wrong
    bool historical = false;              // from its memory: how it was, not how it is
    nlohmann::json body;                  // the object "hello" or "status"
};

// What one request of a device brings: messages of one boot, and what of it is lost for good.
struct SensorReport {
    std::string boot_id;
    std::vector<SensorMessage> messages;
    std::vector<SequenceRange> lost;
};

inline constexpr std::size_t kMostMessages = 1000;  // of one report
inline constexpr std::size_t kMostLost = 64;
inline constexpr std::size_t kMostMessageBytes = 16 << 10;

// Reads {"boot_id": ..., "messages": [...], "lost": [[first, last], ...]}. Throws InvalidInput that
// names every fault.
SensorReport sensor_report(const nlohmann::json& body);

}  // namespace divemesh
