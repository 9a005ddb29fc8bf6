#pragma once

#include <optional>
#include <string>
#include <vector>

#include "schemas/sensor.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// A query of a sensor's history: statuses from `from_ms` to before `to_ms`, in `num_steps` steps of
// equal length. The default of `to_ms` is now, that of `from_ms` the day before.
struct HistoryRequest {
    std::string sensor;
    std::optional<std::int64_t> from_ms;
    std::optional<std::int64_t> to_ms;
    int num_steps = 1000;
    std::vector<std::string> fields;  // of kStatusFields
};

// Returns the history in order of time. Throws Error{NotFound}, Error{InvalidArgument} for an
// unknown field or an end before the beginning.
SensorHistory read_history(Catalog& catalog, const HistoryRequest& request);

}  // namespace divemesh::storage
