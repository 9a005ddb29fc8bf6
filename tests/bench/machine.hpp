#pragma once

#include <nlohmann/json.hpp>

namespace divemesh::bench {

// What figures of speed depend on: processor, cores, memory, system, date.
nlohmann::json describe_machine();

}  // namespace divemesh::bench
