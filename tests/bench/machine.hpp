#pragma once

#include <nlohmann/json.hpp>

namespace divemesh::bench {

// Returns what metrics of speed depend on: processor, cores, memory, operating system, date.
nlohmann::json describe_machine();

}  // namespace divemesh::bench
