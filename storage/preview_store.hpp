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

inline constexpr int kMaxPreviews = 200;         // kept per sensor
inline constexpr int kMaxPreviewsWhenFull = 10;  // kept per sensor while the disk is nearly full

// An image with its bytes.
struct StoredPreview {
    Preview preview;
    std::string jpeg;
    std::int64_t age_ms = 0;  // at the time of reading
};

// Inserts a preview, taken at `time_ms`, and removes the oldest beyond `max_kept`.
Preview insert_preview(soci::session& session,
                       std::int64_t sensor,
                       const SensorMessage& message,
                       std::int64_t time_ms,
                       int max_kept);

// The images that devices sent, newest first.
class PreviewStore {
public:
    explicit PreviewStore(Catalog& catalog) : catalog_(catalog) {}

    std::vector<Preview> list(const std::string& sensor);
    // Returns the newest image; of any camera if `camera` is "". Throws Error{NotFound}.
    StoredPreview newest(const std::string& sensor, const std::string& camera);
    // Throws Error{NotFound}, also for an image that was removed since.
    StoredPreview get(const std::string& sensor, std::int64_t id);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
