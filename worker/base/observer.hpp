#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "schemas/error.hpp"
#include "schemas/job.hpp"

namespace divemesh::base {

// A callback for progress. A stage calls it at least every 200 ms of its work; it throws
// Error{Cancelled} to stop the stage, and no step catches that. It is the only channel between the
// running pipeline and its surroundings.
using ProgressCallback = std::function<void(const Progress&)>;

inline void ignore_progress(const Progress&) {}

}  // namespace divemesh::base
