#pragma once

#include <optional>
#include <string>
#include <vector>

#include "schemas/sensor.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// What is asked of a sensor's history: statuses from `from_ms` to before `to_ms`, in `num_steps`
// steps of the same time. Without `to_ms` until now, without `from_ms` the day before.
struct HistoryRequest {
    std::string sensor;
    std::optional<std::int64_t> from_ms;
    std::optional<std::int64_t> to_ms;
    int num_steps = 1000;
    std::vector<std::string> fields;  // of kStatusFields
};

// In order of time. Throws Error{NotFound}, Error{InvalidArgument} for a field that there is not or
// an end before the begin.
SensorHistory read_history(Catalog& catalog, const HistoryRequest& request);

}  // namespace divemesh::storage
