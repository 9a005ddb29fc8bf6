#pragma once

#include <cstdint>
#include <optional>
#include <soci/soci.h>
#include <string>
#include <vector>

#include "schemas/sensor.hpp"
#include "schemas/sensor_message.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

inline constexpr int kMaxPreviews = 200;  // that are kept of a sensor
inline constexpr int kFewPreviews = 10;   // ... while the disk is nearly full

// A picture with its bytes.
struct StoredPreview {
    Preview preview;
    std::string jpeg;
    std::int64_t age_ms = 0;  // now
};

// Of a preview that came, taken at `time_ms`; the oldest beyond `max_kept` go.
Preview insert_preview(soci::session& session,
                       std::int64_t sensor,
                       const SensorMessage& message,
                       std::int64_t time_ms,
                       int max_kept);

// The pictures that devices sent, newest first.
class PreviewStore {
public:
    explicit PreviewStore(Catalog& catalog) : catalog_(catalog) {}

    std::vector<Preview> list(const std::string& sensor);
    // Of any camera where it is "". Throws Error{NotFound}.
    StoredPreview newest(const std::string& sensor, const std::string& camera);
    // Throws Error{NotFound}, also for one that was removed since.
    StoredPreview get(const std::string& sensor, std::int64_t id);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
