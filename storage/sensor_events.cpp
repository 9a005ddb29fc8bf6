#include "storage/sensor_events.hpp"

#include <utility>

#include "storage/event_store.hpp"

namespace divemesh::storage {

void append_sensor_event(soci::session& session,
                         const Sensor& sensor,
                         const std::string& type,
                         nlohmann::json data) {
    data["sensor"] = sensor.id;
    EventStore::append(session,
                       {.project = sensor.project,
                        .topic = "sensor",
                        .subject = sensor.id,
                        .type = type,
                        .data = std::move(data)});
}

}  // namespace divemesh::storage
