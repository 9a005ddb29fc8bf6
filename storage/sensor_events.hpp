#pragma once

#include <nlohmann/json.hpp>
#include <soci/soci.h>
#include <string>

#include "schemas/sensor.hpp"

namespace divemesh::storage {

// Appends an event of the sensor, inside the transaction of the change.
void append_sensor_event(soci::session& session,
                         const Sensor& sensor,
                         const std::string& type,
                         nlohmann::json data);

}  // namespace divemesh::storage
